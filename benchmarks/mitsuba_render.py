"""Render a Mitsuba scene file to a picture. Run it with the Python of the environment that has Mitsuba.

python mitsuba_render.py SCENE.xml OUT.png
"""

import sys

import mitsuba


def main(scene: str, output: str) -> None:
    """Load and render a scene, and write the picture as 8-bit sRGB."""
    mitsuba.set_variant("llvm_ad_rgb")
    picture = mitsuba.Bitmap(mitsuba.render(mitsuba.load_file(scene)))
    srgb = picture.convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.UInt8, srgb_gamma=True)
    srgb.write(output)


if __name__ == "__main__":
    main(*sys.argv[1:])
