"""From radiance to an image file: exposure, tone curve, sRGB, and the encoders."""
