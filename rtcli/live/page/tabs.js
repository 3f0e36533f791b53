// The panels, one of them open.

import { byId, emit, live } from "/live.js";

const list = document.querySelector("[role=tablist]");
const tabs = [...list.children];

export function openPanel(name) {
  for (const tab of tabs) {
    const isOpen = tab.id === `tab-${name}`;
    tab.ariaSelected = String(isOpen);
    tab.tabIndex = isOpen ? 0 : -1;
    byId(tab.getAttribute("aria-controls")).hidden = !isOpen;
  }
  if (live.state) emit("panel");
}

const nameOf = (tab) => tab.id.replace("tab-", "");

for (const tab of tabs) tab.addEventListener("click", () => openPanel(nameOf(tab)));
list.addEventListener("keydown", (event) => {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!step) return;
  const next = tabs[(tabs.indexOf(event.target) + step + tabs.length) % tabs.length];
  openPanel(nameOf(next));
  next.focus();
});
