// The passes as pictures: colors, legend, and the value of a pixel as text.

import { hex, idColor, number, srgb, viridis } from "/color.js";
import { canvasOf } from "/image.js";

// A scale reaches at most this many times as far as half of the pixels: a floor may extend to the horizon.
const REACH = 16;

const SAMPLE = 100_000;

// The lowest and highest of some values, exactly, and the value that a share of them stays below, from a sample.
function spread(values, keep) {
  let [low, high] = [Infinity, -Infinity];
  const sample = [];
  const step = Math.ceil(values.length / SAMPLE);
  for (let at = 0; at < values.length; at++) {
    if (!keep(values[at], at)) continue;
    if (values[at] < low) low = values[at];
    if (values[at] > high) high = values[at];
    if (Math.floor(at / 3) % step === 0) sample.push(values[at]);
  }
  sample.sort((a, b) => a - b);
  const below = (share) => sample[Math.floor(share * (sample.length - 1))] ?? 1;
  return Number.isFinite(low) ? { low, high, below } : { low: 0, high: 1, below };
}

function scale(values, share, legend) {
  return { color: (at) => (Number.isFinite(values[at]) ? viridis(share(values[at])) : null), legend };
}

function lengths({ values }) {
  const seen = spread(values, Number.isFinite);
  const [low, high] = [seen.low, Math.min(seen.high, REACH * seen.below(0.5))];
  const legend = { low, high, middle: (low + high) / 2, unit: "scene units" };
  return scale(values, (value) => (value - low) / (high - low || 1), legend);
}

const luminance = (r, g, b) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

// Eight stops below the brightest of all but one pixel in a thousand.
function radiances({ values, channels }) {
  const light = new Float32Array(values.length / channels);
  for (let index = 0; index < light.length; index++) {
    const at = index * channels;
    light[index] = luminance(values[at], values[at + 1], values[at + 2]);
  }
  const high = spread(light, (value) => value > 0).below(0.999);
  const low = high / 256;
  const legend = { low, high, middle: high / 16, unit: "luminance of the radiance, logarithmic" };
  return scale(light, (value) => Math.log2(Math.max(value, low) / low) / 8, legend);
}

const isNothing = (values, start) => !values[start] && !values[start + 1] && !values[start + 2];

function directions({ values }) {
  const color = (at) => (isNothing(values, 3 * at) ? null : [0, 1, 2].map((axis) => (values[3 * at + axis] + 1) * 127.5));
  return { color, legend: { text: "red: x, green: y, blue: z, each from −1 to 1" } };
}

function positions({ values }) {
  const ends = [0, 1, 2].map((axis) => {
    const seen = spread(values, (_, at) => at % 3 === axis && !isNothing(values, at - axis));
    const middle = seen.below(0.5);
    const reach = REACH * Math.max(seen.below(0.75) - middle, middle - seen.below(0.25));
    return reach ? [Math.max(seen.low, middle - reach), Math.min(seen.high, middle + reach)] : [seen.low, seen.high];
  });
  const color = (at) => (isNothing(values, 3 * at) ? null
    : ends.map(([low, high], axis) => (255 * (values[3 * at + axis] - low)) / (high - low || 1)));
  const text = ends.map(([low, high], axis) => `${["red: x", "green: y", "blue: z"][axis]} ${number(low, 3)} to ${number(high, 3)}`);
  return { color, legend: { text: `${text.join(", ")} (scene units)` } };
}

function albedos({ values }) {
  const color = (at) => [0, 1, 2].map((channel) => 255 * srgb(values[3 * at + channel]));
  return { color, legend: { text: "the albedo, linear from 0 to 1, shown as sRGB" } };
}

function ids({ values }) {
  const colors = new Map();
  const color = (at) => {
    const id = values[at];
    if (!colors.has(id)) colors.set(id, id ? idColor(id) : null);
    return colors.get(id);
  };
  return { color, legend: { text: "a color for each id; 0 where nothing is hit" } };
}

const triple = (values) => values.map((value) => number(value)).join(" ");

// By name, in the order of the menu. `text` takes the values of one pixel.
export const PASSES = {
  depth: { title: "depth", paint: lengths, text: triple },
  distance: { title: "distance", paint: lengths, text: triple },
  normal: { title: "normal", paint: directions, text: triple },
  position: { title: "position", paint: positions, text: triple },
  albedo: { title: "albedo", paint: albedos, text: (values) => `${triple(values)} (${hex(values.map((each) => Math.round(255 * srgb(each))))})` },
  object_id: { title: "object id", paint: ids, text: triple },
  radiance: { title: "radiance", paint: radiances, text: triple },
};

export async function decodePass(response) {
  const [width, height, channels] = ["X-Width", "X-Height", "X-Channels"].map((name) => Number(response.headers.get(name)));
  const bytes = await response.arrayBuffer();
  const values = response.url.includes("name=object_id") ? new Uint32Array(bytes) : new Float32Array(bytes);
  return { values, width, height, channels };
}

// Nothing hit: a checkered pattern of two grays, which no color of a value has.
export function paint(name, pass) {
  const { color, legend } = PASSES[name].paint(pass);
  const pixels = new Uint8ClampedArray(4 * pass.width * pass.height);
  for (let at = 0, start = 0; start < pixels.length; at++, start += 4) {
    const gray = ((at % pass.width) >> 3) + (Math.floor(at / pass.width) >> 3) & 1 ? 118 : 88;
    const value = color(at);
    pixels[start] = value ? value[0] : gray;
    pixels[start + 1] = value ? value[1] : gray;
    pixels[start + 2] = value ? value[2] : gray;
    pixels[start + 3] = 255;
  }
  return { canvas: canvasOf(pixels, pass.width, pass.height), legend };
}

export function valuesAt(pass, x, y) {
  const start = (y * pass.width + x) * pass.channels;
  return [...pass.values.subarray(start, start + pass.channels)];
}
