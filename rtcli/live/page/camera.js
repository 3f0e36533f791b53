// Poses of a camera: position, look_at and up. They only change what the page shows.

const add = (a, b, factor = 1) => a.map((each, axis) => each + factor * b[axis]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((each) => each / Math.hypot(...a));

// About a unit axis, by Rodrigues's formula.
function rotate(a, axis, angle) {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  return add(add(a.map((each) => each * cos), cross(axis, a), sin), axis, dot(axis, a) * (1 - cos));
}

// Six digits are enough for the eye, and the same numbers go to the server, the command and the file.
export const rounded = (a, size = 1) => {
  const unitOf = 10 ** (Math.floor(Math.log10(size || 1)) - 5);
  return a.map((each) => Number((Math.round(each / unitOf) * unitOf).toPrecision(12)) + 0);
};

function pose(position, look_at, up) {
  const size = Math.max(Math.hypot(...add(look_at, position, -1)), 1e-6);
  return { position: rounded(position, size), look_at: rounded(look_at, size), up };
}

function frame({ position, look_at, up }) {
  const forward = unit(add(look_at, position, -1));
  const right = unit(cross(forward, up));
  return { forward, right, upward: cross(right, forward) };
}

// Looks at the point at a depth instead, in the same direction, so that it turns about what is seen.
export function aim({ position, look_at, up }, depth) {
  return pose(position, add(position, frame({ position, look_at, up }).forward, depth), up);
}

const POLE = 0.02;

// `dx` and `dy` in radians: the scene turns with the pointer.
export function orbit({ position, look_at, up }, dx, dy) {
  const { right } = frame({ position, look_at, up });
  const arm = add(position, look_at, -1);
  const angle = Math.acos(Math.min(Math.max(dot(unit(arm), unit(up)), -1), 1));
  const tilt = Math.min(Math.max(angle - dy, POLE), Math.PI - POLE) - angle;
  const turned = rotate(rotate(arm, right, tilt), unit(up), -dx);
  return pose(add(look_at, turned), look_at, up);
}

// `dx` and `dy` as shares of the distance: the scene moves with the pointer.
export function pan({ position, look_at, up }, dx, dy) {
  const { right, upward } = frame({ position, look_at, up });
  const distance = Math.hypot(...add(look_at, position, -1));
  const shift = add(right.map((each) => -each * dx * distance), upward, dy * distance);
  return pose(add(position, shift), add(look_at, shift), up);
}

export function dolly({ position, look_at, up }, factor) {
  return pose(add(look_at, add(position, look_at, -1), factor), look_at, up);
}

const list = (values) => `[${values.join(", ")}]`;

export function yaml({ position, look_at, up }) {
  return `camera:\n  position: ${list(position)}\n  look_at: ${list(look_at)}\n  up: ${list(up)}`;
}

export function query({ position, look_at, up }) {
  return { position: position.join(","), look_at: look_at.join(","), up: up.join(",") };
}
