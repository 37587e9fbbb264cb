// Dark or light: as the system says, until the user says otherwise.
const kKey = "patinate-theme";
type Theme = "dark" | "light";

function stored(): Theme | undefined {
  try {
    const value = localStorage.getItem(kKey);
    return value === "dark" || value === "light" ? value : undefined;
  } catch {
    return undefined;  // Storage may be forbidden, as in a file opened from disk.
  }
}

export function current_theme(): Theme {
  return (document.documentElement.dataset["theme"] as Theme | undefined) ?? "dark";
}

const listeners = new Set<() => void>();

/// @returns what stops it.
export function on_theme(listener: () => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

function set(theme: Theme): void {
  document.documentElement.dataset["theme"] = theme;
  for (const listener of listeners) listener();
}

export function start_theme(): void {
  const system = window.matchMedia("(prefers-color-scheme: light)");
  set(stored() ?? (system.matches ? "light" : "dark"));
  system.addEventListener("change", () => { if (!stored()) set(system.matches ? "light" : "dark"); });
}

export function toggle_theme(): void {
  const theme = current_theme() === "dark" ? "light" : "dark";
  try {
    localStorage.setItem(kKey, theme);
  } catch {
    // Not kept then.
  }
  set(theme);
}
