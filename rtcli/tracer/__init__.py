"""The tracer: a `World` of plain numbers in, radiance and passes out. It knows no files and no scene model."""
