history.replaceState(null, "", location.pathname + location.hash);
const part = (id) => document.getElementById(id);

new EventSource("/events").addEventListener("state", async () => {
  const state = await (await fetch("/state")).json();
  part("status").textContent = `${state.scene}: ${state.status}`;
  part("report").textContent = state.report;
  if (state.picture) part("picture").src = `/picture?version=${state.picture.version}`;
});
