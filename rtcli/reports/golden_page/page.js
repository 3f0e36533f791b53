"use strict";

import { followPixel, onKeys, valueAt } from "./parts.js";

const views = [...document.querySelectorAll("[name=view]")];
const headings = [...document.querySelectorAll(".result h2")];
const sliders = [...document.querySelectorAll(".slider")];

// --- Views -----------------------------------------------------------------------------------------------

function follow() {
  document.body.classList.toggle("with-slider", views.some((view) => view.checked && view.value === "slider"));
  markEnlarged();
}

// Enlarged pixels have sharp edges; reduced pictures are smooth.
function markEnlarged() {
  for (const image of document.images) {
    image.classList.toggle("enlarged", image.naturalWidth > 0 && image.naturalWidth < image.clientWidth);
  }
}

function move(slider) {
  slider.parentElement.style.setProperty("--at", `${slider.value}%`);
}

views.forEach((view) => view.addEventListener("change", follow));
sliders.forEach((slider) => slider.addEventListener("input", () => move(slider)));
for (const image of document.images) image.addEventListener("load", markEnlarged);
window.addEventListener("resize", markEnlarged);

// --- Keys ------------------------------------------------------------------------------------------------

function currentIndex() {
  const result = document.activeElement.closest(".result");
  return result ? headings.indexOf(result.querySelector("h2")) : -1;
}

// To the slider of a result if it can be seen, so that the arrows move it at once.
function go(index) {
  if (!(index in headings)) return;
  const slider = headings[index].parentElement.querySelector(".slider");
  headings[index].scrollIntoView();
  const target = slider && slider.checkVisibility() ? slider : headings[index];
  target.focus({ preventScroll: true, focusVisible: true });
}

function switchView() {
  const index = currentIndex();
  views.find((view) => !view.checked).checked = true;
  follow();
  if (index >= 0) go(index);
}

onKeys({
  j: () => go(currentIndex() + 1),
  k: () => go(currentIndex() - 1),
  s: switchView,
});

// --- The pixel under the pointer -------------------------------------------------------------------------

for (const sides of document.querySelectorAll(".sides")) {
  const spot = sides.previousElementSibling.querySelector(".spot");
  const images = [...sides.querySelectorAll("img")];
  const show = (pixel) => {
    const values = images.map((image) => `${image.alt.split(":")[0].toLowerCase()} ${pixel && valueAt(image, pixel)}`);
    spot.textContent = pixel ? ` x ${pixel[0]}, y ${pixel[1]}: ${values.join(" · ")}` : "";
  };
  images.forEach((image) => followPixel(image, show));
}

// A browser that comes back to the page may have kept the view and the sliders.
sliders.forEach(move);
follow();
