// Questions and help on top of everything; Escape closes, focus goes back to where it was.
import { button, icon_button } from "./controls";
import { h, type Child } from "./dom";

export function open_dialog(title: string, body: Child[], actions: HTMLElement[] = []): HTMLDialogElement {
  const dialog = h("dialog", { "aria-label": title },
    h("header", {}, h("h2", {}, title), icon_button("close", "Close", () => dialog.close())), h("div", { class: "dialog-body" }, body),
    actions.length > 0 && h("footer", {}, actions));
  dialog.addEventListener("close", () => dialog.remove());
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
}

/// A question; `go` is what happens when the answer is yes.
export function ask(title: string, text: string, yes: string, go: () => void): void {
  const accept = button(yes, () => {
    dialog.close();
    go();
  }, { kind: "primary" });
  const dialog = open_dialog(title, [h("p", {}, text)], [button("Cancel", () => dialog.close()), accept]);
  accept.focus();
}

/// A name for a file or folder. `go` may fail: its message is shown and the dialog stays.
export function ask_path(title: string, label: string, value: string, extra: Child[], go: (path: string) => Promise<void>): void {
  const input = h("input", { type: "text", value, required: true, autocomplete: "off", spellcheck: "false" });
  const problem = h("p", { class: "problem", role: "alert" });
  const accept = button("Save", () => {
    problem.textContent = "";
    accept.disabled = true;
    go(input.value.trim()).then(() => dialog.close(), (error: Error) => {
      problem.textContent = error.message;
      accept.disabled = false;
    });
  }, { kind: "primary" });
  const dialog = open_dialog(title, [h("label", { class: "field" }, label, input), ...extra, problem], [button("Cancel", () => dialog.close()), accept]);
  input.addEventListener("keydown", (event) => { if (event.key === "Enter") accept.click(); });
  input.select();
}

const kKeys: [string, string][] = [
  ["Space", "play or pause"], ["F", "fit the view"], ["← →", "a frame back or on"], ["1 2 3", "one time, wipe, difference"],
  ["P", "paint on the surface; then the wheel is the brush's distance, Shift and wheel its size, Ctrl and wheel comes closer"], ["G R S", "handles: move, rotate, scale"], ["Ctrl Z", "undo the last step: a setting, a move, a look, a stroke, or the way back to the start"], ["Ctrl Shift Z", "redo; Ctrl Y too"],
  ["Shift F", "full screen"], ["T", "dark or light"], ["Esc", "let go"], ["?", "this page"],
];

export function open_help(): void {
  open_dialog("Finding your way", [
    h("p", {}, "Drag to turn, with the right button (or two fingers) to shift, wheel or pinch to come closer. A click on the surface shows all its numbers there, and how they change."),
    h("table", { class: "keys" }, h("tbody", {}, kKeys.map(([key, text]) => h("tr", {}, h("td", {}, h("kbd", {}, key)), h("td", {}, text))))),
    h("p", {}, "docs/studio.md has more."),
  ]);
}
