// Keys by name.

export interface Pressed {
  key: string;
  code?: string;
  ctrlKey: boolean;
  metaKey: boolean;
  altKey: boolean;
  shiftKey: boolean;
}

const is_letter = (key: string): boolean => key.length === 1 && key.toLowerCase() !== key.toUpperCase();

/// What was pressed: "ctrl+shift+z", "f", "shift+f", "?", "ArrowLeft". Letters are small whatever Shift and Caps Lock make of them; the command key counts as Ctrl.
/// With Ctrl, a keyboard of other letters gives the one that is printed there on a Latin one.
export function key_of(event: Pressed): string {
  const has_ctrl = event.ctrlKey || event.metaKey;
  const latin = /^Key([A-Z])$/.exec(event.code ?? "")?.[1];
  const letter = has_ctrl && is_letter(event.key) && !/^[a-z]$/i.test(event.key) && latin ? latin : event.key;
  const key = is_letter(letter) ? letter.toLowerCase() : letter;
  return `${has_ctrl ? "ctrl+" : ""}${event.altKey ? "alt+" : ""}${event.shiftKey && is_letter(letter) ? "shift+" : ""}${key}`;
}
