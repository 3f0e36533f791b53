"use strict";

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

const actions = {
  j: () => go(currentIndex() + 1),
  k: () => go(currentIndex() - 1),
  s: switchView,
};

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  actions[event.key.toLowerCase()]?.();
});

// A browser that comes back to the page may have kept the view and the sliders.
sliders.forEach(move);
follow();
