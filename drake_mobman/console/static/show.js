// The session's state, shown on the page.

const ARMING = ["latched", "ready", "armed"];
const ROLE = {
  you: "you drive",
  another: "you watch, another page drives",
  nobody: "nobody drives",
};

const find = (name) => document.querySelector(`.${name}`);

function put(name, text) {
  const element = find(name);
  if (element && element.textContent !== text) element.textContent = text;
}

// `aside` is the page's own notice, shown if nothing is more urgent.
export function show(state, aside) {
  const root = document.documentElement.dataset;
  root.role = state.role;
  root.arming = ARMING[state.arming];
  root.recording = state.recording ? "on" : "off";
  root.asked = state.asked && state.role === "you" ? "yes" : "no";
  put("status", state.text);
  put("role", ROLE[state.role] + (state.pages > 1 ? ` · ${state.pages} pages` : ""));
  put("time", `${state.time.toFixed(1)} s`);
  put("ratio", state.ratio === null ? "" : `× ${state.ratio.toFixed(2)}`);
  put("recording", state.recording ? `recording to ${state.recording}` : "");
  const asked = state.asked && state.role === "you" ? "another page asks for the stick" : "";
  put("notice", state.problem || state.notice || asked || aside);
  for (const choice of document.querySelectorAll(".choose")) {
    choice.ariaPressed = choice.dataset.choice === state.choice;
  }
}

export function showClosed(why) {
  const root = document.documentElement.dataset;
  root.role = "nobody";
  root.arming = "latched";
  put("status", "no connection to the session" + (why ? `: ${why}` : ""));
}
