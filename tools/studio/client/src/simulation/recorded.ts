// What an earlier run of the program has left of a scene.
import type { Recording } from "../types";

/// What a button says that goes through it again: "Resume what was painted (120 iterations, saved 21 Nov 2026, 16:04)", in the reader's time and language.
export function recording_text(recording: Recording, locale?: string): string {
  const { iterations, saved } = recording;
  const when = new Date(saved);
  const time = Number.isNaN(when.getTime()) ? "" : `, saved ${when.toLocaleString(locale, { dateStyle: "medium", timeStyle: "short" })}`;
  return `Resume what was painted (${iterations} iteration${iterations === 1 ? "" : "s"}${time})`;
}

/// Whether two are the same one, so that who has dismissed it is not asked again.
export function is_same_recording(a: Recording | null | undefined, b: Recording | null | undefined): boolean {
  return a?.saved === b?.saved && a?.iterations === b?.iterations && a?.events === b?.events;
}
