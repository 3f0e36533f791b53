// Colors of values. Viridis (S. van der Walt and N. Smith, 2015) is perceptually even, and its lightness rises.

const STOPS = [
  [68, 1, 84], [72, 26, 108], [71, 47, 125], [65, 68, 135], [57, 86, 140], [49, 104, 142], [42, 120, 142],
  [35, 136, 142], [31, 152, 139], [34, 168, 132], [53, 183, 121], [84, 197, 104], [122, 209, 81], [165, 219, 54],
  [210, 226, 27], [253, 231, 37],
];

const LEVELS = Array.from({ length: 1024 }, (_, level) => {
  const place = (level / 1023) * (STOPS.length - 1);
  const first = Math.min(Math.floor(place), STOPS.length - 2);
  return STOPS[first].map((low, channel) => Math.round(low + (place - first) * (STOPS[first + 1][channel] - low)));
});

// `share` from 0 to 1.
export function viridis(share) {
  return LEVELS[Math.round(Math.min(Math.max(share, 0), 1) * 1023)];
}

export function srgb(linear) {
  const value = Math.min(Math.max(linear, 0), 1);
  return value <= 0.04045 / 12.92 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
}

// The color of an id, as `rtcli render --passes object_id` has it.
export function idColor(id) {
  const code = (id * 0x9e3779) % 2 ** 24;
  const color = [0, 0, 0];
  for (let bit = 0; bit < 24; bit++) {
    if ((code >> (23 - bit)) & 1) color[bit % 3] |= 1 << (7 - Math.floor(bit / 3));
  }
  return color;
}

export function hex(color) {
  return `#${color.map((level) => level.toString(16).padStart(2, "0")).join("")}`;
}

export function number(value, digits = 6) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : "nothing hit";
}
