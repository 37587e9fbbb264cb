// Meshes that come into the served folder: chosen, or dropped on the page.
import { post_file, url_of } from "../api";
import { h } from "../ui/dom";
import { icon } from "../ui/icons";
import { notice, settle, show_error } from "../ui/notices";
import { plain_name } from "./paths";

const kMeshes = [".obj", ".ply", ".stl", ".glb"];
const kMost_mb = 128;
const kAbout = "/api/mesh";

/// Sends the first mesh among some files. @returns its place; nothing where there is none, which is said.
export async function upload(files: Iterable<File>): Promise<string | undefined> {
  const file = [...files].find(({ name }) => is_mesh_file(name));
  if (!file) {
    notice(`Choose a mesh, an ${kMeshes.map((end) => end.slice(1).toUpperCase()).join(", ")} file, or photographs.`, "error", kAbout);
    return undefined;
  }
  if (file.size > kMost_mb * 1048576) {
    notice(`${file.name} is larger than ${kMost_mb} MB. Copy it into the folder, and load this page again.`, "error", kAbout);
    return undefined;
  }
  try {
    notice(`${file.name} is on its way ...`, "info", kAbout);
    const { place } = await post_file<{ place: string }>(url_of(kAbout, { name: plain_name(file.name) }), file);
    settle(kAbout);
    return place;
  } catch (error) {
    show_error(error, kAbout);
    return undefined;
  }
}

/// A button that opens the browser's dialog for files.
export function choose_mesh(text: string, take: (place: string) => void, kind = ""): HTMLElement {
  const input = h("input", { type: "file", accept: kMeshes.join(","), hidden: true });
  input.onchange = () => {
    void upload(input.files ?? []).then((place) => { if (place) take(place); });
    input.value = "";
  };
  return h("div", { class: "choose" }, h("button", { type: "button", class: kind, onclick: () => input.click() }, icon("plus"), h("span", {}, text)), input);
}

export const is_mesh_file = (name: string): boolean => kMeshes.some((end) => name.toLowerCase().endsWith(end));

/// Files may be dropped anywhere on an element.
export function drop_files(element: HTMLElement, take: (data: DataTransfer) => void): void {
  const has_files = (event: DragEvent): boolean => [...(event.dataTransfer?.types ?? [])].includes("Files");
  element.addEventListener("dragover", (event) => {
    if (!has_files(event)) return;
    event.preventDefault();
    element.classList.add("dropping");
  });
  element.addEventListener("dragleave", (event) => { if (!element.contains(event.relatedTarget as Node | null)) element.classList.remove("dropping"); });
  element.addEventListener("drop", (event) => {
    element.classList.remove("dropping");
    if (!event.dataTransfer || !has_files(event)) return;
    event.preventDefault();
    take(event.dataTransfer);
  });
}
