// One go of a hand: from pressing a button or a key until the next one is pressed. Changes of one go are one step that can be undone.
let number = 1;

const next = (event: Event): void => { if (!(event instanceof KeyboardEvent && event.repeat)) ++number; };
window.addEventListener("pointerdown", next, { capture: true });
window.addEventListener("keydown", next, { capture: true });

/// Another one for each.
export function gesture(): number {
  return number;
}
