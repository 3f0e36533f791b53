// Requests to the server, and its stream of events.

export class ServerError extends Error {
  constructor(status, message) {
    super(message);
    this.status = status;
  }
}

async function answer(path, options) {
  const response = await fetch(path, options);
  if (response.ok) return response;
  const { error } = await response.json().catch(() => ({}));
  throw new ServerError(response.status, error ?? `The server answered ${response.status}.`);
}

export function get(path, query = {}) {
  const text = new URLSearchParams(query).toString();
  return answer(text ? `${path}?${text}` : path, { cache: "no-store" });
}

export async function getJson(path, query) {
  return (await get(path, query)).json();
}

export function post(path, body) {
  const headers = { "Content-Type": "application/json", "X-Rtcli": "1" };
  return answer(path, { method: "POST", headers, body: JSON.stringify(body) });
}

// Returns a function that does the work for its newest arguments: calls during the work are one call after it.
export function newest(work, onError) {
  let waiting = null;
  let isBusy = false;
  return async (...values) => {
    waiting = values;
    if (isBusy) return;
    isBusy = true;
    while (waiting) {
      const now = waiting;
      waiting = null;
      try {
        await work(...now);
      } catch (error) {
        onError(error);
      }
    }
    isBusy = false;
  };
}

const LONGEST_WAIT = 10;

// Follows the server's events; closed while the tab is hidden, since a browser has few connections for all tabs.
export class Events {
  constructor({ onEvent, onOpen, onGone }) {
    this.handlers = { onEvent, onOpen, onGone };
    this.stream = null;
    this.timer = 0;
    this.wait = 0;
    document.addEventListener("visibilitychange", () => this.follow());
    window.addEventListener("pagehide", () => this.close());
    window.addEventListener("pageshow", () => this.follow());
    this.follow();
  }

  close() {
    clearTimeout(this.timer);
    this.stream?.close();
    this.stream = null;
  }

  follow() {
    if (document.hidden) {
      this.close();
    } else if (!this.stream) {
      this.open();
    }
  }

  // At once, instead of after the pause.
  retry() {
    this.wait = 0;
    this.open();
  }

  open() {
    this.close();
    this.stream = new EventSource("/events");
    this.stream.addEventListener("open", () => {
      this.wait = 0;
      this.handlers.onOpen();
    });
    this.stream.addEventListener("state", (event) => this.handlers.onEvent(JSON.parse(event.data)));
    this.stream.addEventListener("error", () => this.lost());
  }

  async lost() {
    this.close();
    this.wait = Math.min(LONGEST_WAIT, this.wait ? this.wait * 2 : 0.5);
    this.timer = setTimeout(() => this.follow(), this.wait * 1000);
    const isRefused = await get("/state").then(() => false, (error) => error.status === 403);
    if (!this.stream) this.handlers.onGone(this.wait, isRefused);
  }
}
