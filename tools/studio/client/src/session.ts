// Static sessions: answers requests from the page itself, without a server.
import type { StaticSession, StoredResponse } from "./types";

export interface Reply {
  bytes: ArrayBuffer;
  type: string;
  header(name: string): string | null;
}

function parameters(url: string): { path: string; query: URLSearchParams } {
  const [path = "", query = ""] = url.split("?");
  return { path, query: new URLSearchParams(query) };
}

function decode(stored: StoredResponse): Reply {
  const text = atob(stored.base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  const headers = new Map(Object.entries(stored.headers ?? {}).map(([name, value]) => [name.toLowerCase(), value]));
  return { bytes: bytes.buffer, type: stored.type, header: (name) => headers.get(name.toLowerCase()) ?? null };
}

const kSizeless = ["size", "format", "between", "tile", "width"];

/// How far a stored request is from what is asked: 0 the same, a difference of times where only that differs, else infinite.
function distance(asked: ReturnType<typeof parameters>, stored: ReturnType<typeof parameters>): number {
  if (asked.path !== stored.path) return Infinity;
  for (const name of new Set([...asked.query.keys(), ...stored.query.keys()])) {
    if (kSizeless.includes(name) || name === "time") continue;
    const [a, b] = [asked.query.get(name), stored.query.get(name)];
    if (a !== b && !(a !== null && b !== null && Number(a) === Number(b))) return Infinity;
  }
  const [a, b] = [asked.query.get("time"), stored.query.get("time")];
  if ((a === null) !== (b === null)) return Infinity;
  return a === null ? 0 : Math.abs(Number(a) - Number(b));
}

/// @returns the stored answer that is nearest in time, undefined where there is none.
export function answer_from(session: StaticSession, url: string): Reply | undefined {
  const exact = session.responses[url];
  if (exact) return decode(exact);
  const asked = parameters(url);
  let best: StoredResponse | undefined;
  let least = Infinity;
  for (const [key, stored] of Object.entries(session.responses)) {
    const d = distance(asked, parameters(key));
    if (d < least) [best, least] = [stored, d];
  }
  return best && decode(best);
}

/// The times whose textures are in the page.
export function stored_times(session: StaticSession): number[] {
  const times = new Set<number>();
  for (const key of Object.keys(session.responses)) {
    const { path, query } = parameters(key);
    const time = query.get("time");
    if (path === "/api/texture" && time !== null && query.get("place") === session.place) times.add(Number(time));
  }
  return [...times].sort((a, b) => a - b);
}
