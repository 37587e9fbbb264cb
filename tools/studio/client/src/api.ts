// Requests to the server, or to the page itself in a static session.
import { answer_from, type Reply } from "./session";
import type { Curve, PlaceBase, Places } from "./types";

/// What went wrong, as a sentence for the user.
export class StudioError extends Error {
  /// @param about  What has failed: a request's path, kServer, or "" for what can only be said once.
  /// @param argument  The argument of a command whose value is wrong.
  constructor(message: string, readonly about = "", readonly argument = "") {
    super(message);
  }
}

/// What a StudioError is about when nothing answers.
export const kServer = "server";
const kNoAnswer = "The server does not answer. Is `patinate studio` still running, and the ssh tunnel open?";

export function is_static(): boolean {
  return window.PATINATE_SESSION !== undefined;
}

export function url_of(path: string, query: Record<string, string | number | undefined> = {}): string {
  const parts = Object.entries(query).filter(([, value]) => value !== undefined);
  const text = parts.map(([name, value]) => `${name}=${encodeURIComponent(String(value))}`).join("&");
  return text ? `${path}?${text}` : path;
}

async function fail(response: Response, about: string): Promise<never> {
  if (response.status === 403) {
    throw new StudioError("The server does not know this browser (any more). Open the address that `patinate studio` printed, with its token.", kServer);
  }
  const text = await response.text().catch(() => "");
  let message = text, argument: string | undefined;
  try {
    const said = JSON.parse(text) as { error?: string; argument?: string };
    message = said.error ?? text;
    argument = said.argument;
  } catch {
    // Plain text then.
  }
  throw new StudioError(message.trim() || `The server answered ${response.status} and said no more.`, about, argument);
}

const path_of = (url: string): string => url.split("?")[0]!;

let num_waiting = 0;
const kBusyEvent = "patinate-busy", kAnswerEvent = "patinate-answer";

function count(by: number): void {
  num_waiting += by;
  window.dispatchEvent(new CustomEvent(kBusyEvent, { detail: num_waiting }));
}

/// Tells `listener` how many requests are on their way.
export function on_busy(listener: (num: number) => void): void {
  window.addEventListener(kBusyEvent, (event) => listener((event as CustomEvent<number>).detail));
}

/// Tells `listener` the path of every request that has been answered as it should.
export function on_answer(listener: (path: string) => void): void {
  window.addEventListener(kAnswerEvent, (event) => listener((event as CustomEvent<string>).detail));
}

async function answer_of(url: string, options: RequestInit): Promise<Response> {
  const response = await fetch(url, options).catch((error: unknown) => {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    throw new StudioError(kNoAnswer, kServer);
  });
  if (!response.ok) await fail(response, path_of(url));
  window.dispatchEvent(new CustomEvent(kAnswerEvent, { detail: path_of(url) }));
  return response;
}

/// @throws StudioError, or an AbortError where `signal` was used.
export async function get(url: string, signal?: AbortSignal): Promise<Reply> {
  if (window.PATINATE_SESSION) {
    const reply = answer_from(window.PATINATE_SESSION, url);
    if (!reply) throw new StudioError("This is not part of the saved session; it needs a running `patinate studio`.");
    return reply;
  }
  count(1);
  try {
    const response = await answer_of(url, signal ? { signal } : {});
    const bytes = await response.arrayBuffer();
    return { bytes, type: response.headers.get("Content-Type") ?? "", header: (name) => response.headers.get(name) };
  } finally {
    count(-1);
  }
}

export async function get_json<T>(url: string, signal?: AbortSignal): Promise<T> {
  const reply = await get(url, signal);
  return JSON.parse(new TextDecoder().decode(reply.bytes)) as T;
}

/// The bytes of a file. @returns the server's answer.
export async function post_file<T>(url: string, file: Blob): Promise<T> {
  count(1);
  try {
    return (await (await answer_of(url, { method: "POST", headers: { "Content-Type": "application/octet-stream" }, body: file })).json()) as T;
  } finally {
    count(-1);
  }
}

export async function post(url: string, body: unknown): Promise<Blob> {
  count(1);
  try {
    const response = await answer_of(url, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
    return await response.blob();
  } finally {
    count(-1);
  }
}

/// RGBA8 rows, the first at the top.
export interface Texture {
  width: number;
  height: number;
  bytes: Uint8Array;
  hash: string | null;
}

async function decode_picture(bytes: ArrayBuffer, type: string): Promise<Texture> {
  const bitmap = await createImageBitmap(new Blob([bytes], { type }), { premultiplyAlpha: "none", colorSpaceConversion: "none" });
  const canvas = document.createElement("canvas");
  canvas.width = bitmap.width;
  canvas.height = bitmap.height;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) throw new StudioError("This browser cannot decode pictures.");
  context.drawImage(bitmap, 0, 0);
  const data = context.getImageData(0, 0, bitmap.width, bitmap.height).data;
  return { width: bitmap.width, height: bitmap.height, bytes: new Uint8Array(data.buffer), hash: null };
}

export interface TextureQuery {
  place: string;
  time: number;
  between?: string;
  size?: number;
  map?: string;  ///< Default: color.
}

/// Color, or a map of the material, at a time.
export async function get_texture(query: TextureQuery, signal?: AbortSignal): Promise<Texture> {
  const reply = await get(url_of("/api/texture", { ...query, format: "raw" }), signal);
  if (reply.type.startsWith("image/")) return decode_picture(reply.bytes, reply.type);
  const width = Number(reply.header("X-Width"));
  const height = Number(reply.header("X-Height"));
  if (!(width > 0 && height > 0 && reply.bytes.byteLength === 4 * width * height)) throw new StudioError("The server sent a texture that is not as large as it says.");
  return { width, height, bytes: new Uint8Array(reply.bytes), hash: reply.header("X-Hash") };
}

export interface FloatMap {
  width: number;
  height: number;
  channels: number;
  unit: string;
  values: Float32Array;
}

/// @param time  Of maps that frames have.
export async function get_map(place: string, name: string, size?: number, signal?: AbortSignal, time?: number): Promise<FloatMap> {
  const reply = await get(url_of("/api/map", { place, name, size, time }), signal);
  const [width, height, channels] = ["X-Width", "X-Height", "X-Channels"].map((h) => Number(reply.header(h))) as [number, number, number];
  const values = new Float32Array(reply.bytes);
  if (values.length !== width * height * channels) throw new StudioError("The server sent a map that is not as large as it says.");
  return { width, height, channels, unit: reply.header("X-Unit") ?? "", values };
}

export const get_places = (signal?: AbortSignal): Promise<Places> => get_json("/api/places", signal);
export const get_place = <T extends PlaceBase>(place: string, signal?: AbortSignal): Promise<T> => get_json(url_of("/api/place", { place }), signal);
export const get_curve = (place: string, x: number, y: number, signal?: AbortSignal): Promise<Curve> => get_json(url_of("/api/curve", { place, x, y }), signal);
/// @param texels  Along each side of the texture: the mesh is cut to them, for heights that move it.
export const get_mesh = async (place: string, signal?: AbortSignal, texels?: number): Promise<ArrayBuffer> => (await get(url_of("/api/mesh", { place, texels }), signal)).bytes;

/// Where small plants can grow: rows of numbers, as the protocol has them.
export const get_plants = async (place: string): Promise<Float32Array> => new Float32Array((await get(url_of("/api/plants", { place }))).bytes);

/// image: of a movie, from 0.
export function preview_url(place: string, path: string, width?: number, image?: number): string {
  return url_of("/api/preview", { place, path, width, image });
}

export function thumbnail_url(place: string, time: number, size: number): string {
  return url_of("/api/texture", { place, time, size, format: "png" });
}
