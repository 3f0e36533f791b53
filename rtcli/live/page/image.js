// Pictures: their pixels, what differs between two, and what is clipped.

import { viridis } from "/color.js";

export class Picture {
  constructor(bitmap) {
    this.bitmap = bitmap;
    this.width = bitmap.width;
    this.height = bitmap.height;
    this.bytes = null;
  }

  // Decoded off the main thread.
  static async of(response) {
    const options = { colorSpaceConversion: "none", premultiplyAlpha: "none" };
    return new Picture(await createImageBitmap(await response.blob(), options));
  }

  // RGBA, read once when first needed.
  get pixels() {
    if (!this.bytes) {
      const canvas = new OffscreenCanvas(this.width, this.height);
      const context = canvas.getContext("2d", { willReadFrequently: true });
      context.drawImage(this.bitmap, 0, 0);
      this.bytes = context.getImageData(0, 0, this.width, this.height).data;
    }
    return this.bytes;
  }

  color(x, y) {
    const start = 4 * (y * this.width + x);
    return [...this.pixels.subarray(start, start + 3)];
  }
}

export function canvasOf(pixels, width, height) {
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d").putImageData(new ImageData(pixels, width, height), 0, 0);
  return canvas;
}

// The largest difference of the three channels, in false color over a faint gray picture; null if sizes differ.
export function difference(before, now) {
  if (before.width !== now.width || before.height !== now.height) return null;
  const [a, b] = [before.pixels, now.pixels];
  const levels = new Uint8Array(now.width * now.height);
  let [most, count] = [0, 0];
  for (let index = 0, at = 0; index < levels.length; index++, at += 4) {
    const level = Math.max(Math.abs(a[at] - b[at]), Math.abs(a[at + 1] - b[at + 1]), Math.abs(a[at + 2] - b[at + 2]));
    levels[index] = level;
    if (level > 0) count++;
    if (level > most) most = level;
  }
  const pixels = new Uint8ClampedArray(a.length);
  for (let index = 0, at = 0; index < levels.length; index++, at += 4) {
    if (levels[index]) {
      pixels.set(viridis(0.15 + (0.85 * levels[index]) / most), at);
    } else {
      pixels.fill((b[at] + 2 * b[at + 1] + b[at + 2]) / 12, at, at + 3);
    }
    pixels[at + 3] = 255;
  }
  return { canvas: canvasOf(pixels, now.width, now.height), levels, most, count };
}

export const WHITE = 1;
export const BLACK = 2;

// Counts of each level by channel, and of the clipped pixels with a mask for each kind.
export function histogram(picture) {
  const { pixels, width, height } = picture;
  const bins = [new Uint32Array(256), new Uint32Array(256), new Uint32Array(256)];
  const masks = { [WHITE]: new Uint8ClampedArray(pixels.length), [BLACK]: new Uint8ClampedArray(pixels.length) };
  const clipped = { [WHITE]: 0, [BLACK]: 0 };
  for (let at = 0; at < pixels.length; at += 4) {
    const [r, g, b] = [pixels[at], pixels[at + 1], pixels[at + 2]];
    bins[0][r]++;
    bins[1][g]++;
    bins[2][b]++;
    const kind = Math.max(r, g, b) === 255 ? WHITE : Math.max(r, g, b) === 0 ? BLACK : 0;
    if (kind) {
      clipped[kind]++;
      masks[kind][at + 3] = 255;
    }
  }
  return { bins, clipped, masks, width, height };
}
