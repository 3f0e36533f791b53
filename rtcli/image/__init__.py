"""From radiance to an image file and back: exposure, tone curve, sRGB, encoders and decoders."""
