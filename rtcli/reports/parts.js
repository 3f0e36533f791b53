// What several pages share: keys, and the pixel under the pointer.

import { make } from "./element.js";

// Calls the action of a key that is pressed alone, unless it is typed into a field or belongs to a slider or a list.
export function onKeys(actions, isActive = () => true) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.shiftKey || !isActive()) return;
    if (event.target.matches("input:is([type=search], [type=text]), select, textarea")) return;
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    if (event.key.length === 1) event.preventDefault();
    action(event);
  });
}

// --- The pixel under the pointer -------------------------------------------------------------------------

const pixels = new WeakMap(); // of each picture whose values may be read

function contextOf(image) {
  if (!pixels.has(image) || pixels.get(image).src !== image.currentSrc) {
    const canvas = make("canvas", { width: image.naturalWidth, height: image.naturalHeight });
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    pixels.set(image, { src: image.currentSrc, context });
  }
  return pixels.get(image).context;
}

// The 8-bit values of a pixel, or null where the browser does not let a page read a file beside it.
export function valueAt(image, [x, y]) {
  try {
    const [red, green, blue, alpha] = contextOf(image).getImageData(x, y, 1, 1).data;
    return alpha === 255 ? `${red} ${green} ${blue}` : `${red} ${green} ${blue}, alpha ${alpha}`;
  } catch {
    return null;
  }
}

// Calls show([column, row]) with the pixel under the pointer, and show(null) when it leaves the picture.
export function followPixel(image, show) {
  image.addEventListener("pointermove", (event) => {
    // The picture is fitted into its element, in the middle.
    const scale = Math.min(image.clientWidth / image.naturalWidth, image.clientHeight / image.naturalHeight);
    const x = Math.floor((event.offsetX - image.clientWidth / 2) / scale + image.naturalWidth / 2);
    const y = Math.floor((event.offsetY - image.clientHeight / 2) / scale + image.naturalHeight / 2);
    show(x >= 0 && y >= 0 && x < image.naturalWidth && y < image.naturalHeight ? [x, y] : null);
  });
  image.addEventListener("pointerleave", () => show(null));
}
