// "Begin with photographs": they are copied into a new folder, and `init` says what they are.
import { get_json, get_places, post, post_file, StudioError, url_of } from "../api";
import { plain_name } from "../build/paths";
import { drop_files } from "../build/upload";
import { start_job } from "../jobs/job_buttons";
import { jobs_panel } from "../jobs/jobs_panel";
import type { JobCommands, JobInfo } from "../types";
import { button } from "../ui/controls";
import { open_dialog } from "../ui/dialog";
import { h, replace } from "../ui/dom";
import { notice, show_error } from "../ui/notices";
import { is_photograph, kPhotographs, photograph_names, type ChosenFile } from "./photograph_files";

const kPost = "/api/photographs", kFolder = "/api/photographs/folder", kJobs = "/api/jobs";
const kMost_mb = 128, kMost = 2000, kMostOfAll_mb = 8192, kMb = 1048576, kLook_ms = 250;

/// Files that were dropped, those of folders too. Call it while the event is handled.
export async function dropped_files(data: DataTransfer): Promise<ChosenFile[]> {
  const entries = [...data.items].map((item) => item.webkitGetAsEntry());
  const plain = [...data.files].map((file) => ({ file, path: file.name }));
  if (!entries.some((entry) => entry?.isDirectory)) return plain;
  const found: ChosenFile[] = [];
  const walk = async (entry: FileSystemEntry, folder: string): Promise<void> => {
    if (entry.isFile) found.push({ file: await new Promise<File>((done, fail) => (entry as FileSystemFileEntry).file(done, fail)), path: folder + entry.name });
    if (!entry.isDirectory) return;
    const reader = (entry as FileSystemDirectoryEntry).createReader();
    for (;;) {  // A hundred at a time.
      const some = await new Promise<FileSystemEntry[]>((done, fail) => reader.readEntries(done, fail));
      if (some.length === 0) return;
      for (const each of some) await walk(each, `${folder}${entry.name}/`);
    }
  };
  for (const entry of entries) if (entry) await walk(entry, "");
  return found;
}

/// Until a job has ended. @returns what is then known of it.
async function job_end(id: number): Promise<JobInfo> {
  for (;;) {
    const job = (await get_json<{ jobs: JobInfo[] }>(kJobs)).jobs.find((each) => each.id === id);
    if (!job) throw new Error("The job is not listed any more.");
    if (job.state !== "waiting" && job.state !== "running") return job;
    await new Promise((resolve) => setTimeout(resolve, kLook_ms));
  }
}

class PhotographsDialog {
  private files: ChosenFile[] = [];
  private names: string[] = [];  ///< In the folder.
  private folder = "";           ///< That was made; "" = none yet.
  private num_sent = 0;
  private is_canceled = false;
  private readonly name = h("input", { type: "text", autocomplete: "off", spellcheck: "false", oninput: () => { this.is_named = true; } });
  private is_named = false;
  private readonly summary = h("p", { class: "summary", role: "status" });
  private readonly problem = h("p", { class: "problem", role: "alert" });
  private readonly bar = h("progress", { max: 1, value: 0, hidden: true, "aria-label": "Photographs that have come" });
  private readonly accept = button("Copy and look at them", () => void this.go(), { kind: "primary" });
  private readonly skip = button("Leave it out", () => { this.files.splice(this.num_sent, 1); this.names.splice(this.num_sent, 1); void this.go(); });
  private readonly dialog: HTMLDialogElement;

  constructor(private readonly taken: Set<string>, ready: number) {
    const drop = h("div", { class: "drop" }, h("p", {}, "Drop photographs of one surface here, or a folder of them: pictures, camera RAW, or a movie."),
      h("div", { class: "actions" }, this.chooser("Choose photographs", {}), this.chooser("Choose a folder", { webkitdirectory: true })));
    const here = button("Use a folder that is here already", () => { this.dialog.close(); start_job("init", {}); }, { kind: "quiet" });
    this.dialog = open_dialog("Begin with photographs", [drop, this.summary, h("label", { class: "field" }, "Name of the new folder", this.name), this.bar, this.problem,
      h("p", { class: "hint" }, "They are copied into a new folder of the folder that is served. Then `patinate init` drafts a capture of them, and says what it has found."), ready > 0 && here],
    [button("Cancel", () => this.dialog.close()), this.skip, this.accept]);
    this.dialog.classList.add("photographs");
    this.dialog.addEventListener("close", () => {
      this.is_canceled = true;
      if (this.folder && this.num_sent < this.files.length) notice(`${this.num_sent} of ${this.files.length} photographs are in ${this.folder}, which stays.`, "info", kPost);
    });
    drop_files(drop, (data) => void dropped_files(data).then((files) => this.take(files), (error: unknown) => this.fail(error)));
    this.skip.hidden = true;
    this.take([]);
  }

  take(files: ChosenFile[]): void {
    if (this.folder) return;  // They are on their way.
    const good = files.filter(({ file }) => is_photograph(file.name)), large = good.filter(({ file }) => file.size > kMost_mb * kMb);
    if (files.length > 0) this.files = good.filter((each) => !large.includes(each)).sort((a, b) => a.path.localeCompare(b.path, "en", { numeric: true }));
    const mb = this.files.reduce((sum, { file }) => sum + file.size, 0) / kMb, others = files.length - good.length;
    this.summary.textContent = this.files.length === 0 ? "" : `${this.files.length === 1 ? "1 file" : `${this.files.length} photographs`}, ${mb < 10 ? mb.toFixed(1) : Math.round(mb)} MB${others > 0 ? `; ${others} other ${others === 1 ? "file is" : "files are"} left out` : ""}`;
    this.problem.textContent = large.length > 0 ? `${large[0]!.file.name}${large.length > 1 ? ` and ${large.length - 1} more` : ""}: larger than ${kMost_mb} MB; copy such files into the folder with other programs.` : files.length > 0 && good.length === 0 ? "There are no photographs among these files." : "";
    if (this.files.length > kMost || mb > kMostOfAll_mb) this.problem.textContent = `At most ${kMost} photographs and ${kMostOfAll_mb / 1024} GB are copied in this way; copy more into the folder with other programs.`;
    this.accept.disabled = this.files.length === 0 || this.files.length > kMost || mb > kMostOfAll_mb;
    if (!this.is_named) this.name.value = this.free_name(plain_name(this.files[0]?.path.split("/").slice(-2, -1)[0] ?? "", "photographs").replace(/\.+/g, "_"));
  }

  private free_name(name: string): string {
    for (let k = 1; ; ++k) if (!this.taken.has(k === 1 ? name : `${name}-${k}`)) return k === 1 ? name : `${name}-${k}`;
  }

  private chooser(text: string, more: Record<string, unknown>): HTMLElement {
    const input = h("input", { type: "file", multiple: true, hidden: true, accept: kPhotographs, ...more });
    input.onchange = () => {
      this.take([...(input.files ?? [])].map((file) => ({ file, path: file.webkitRelativePath || file.name })));
      input.value = "";
    };
    return h("div", { class: "choose" }, h("button", { type: "button", onclick: () => input.click() }, text), input);
  }

  private fail(error: unknown): void {
    if (this.is_canceled) show_error(error, kPost);
    this.problem.textContent = error instanceof Error ? error.message : String(error);
    this.accept.disabled = this.files.length === 0;
    this.skip.hidden = !(error instanceof StudioError && error.about === kPost);
  }

  // What has come is not sent again after an error.
  private async go(): Promise<void> {
    this.problem.textContent = "";
    this.accept.disabled = this.skip.hidden = true;
    try {
      if (!this.folder) {
        this.folder = (JSON.parse(await (await post(kFolder, { name: this.name.value.trim() })).text()) as { folder: string }).folder;
        this.names = photograph_names(this.files);
      }
      this.name.disabled = true;
      this.bar.hidden = false;
      for (; this.num_sent < this.files.length; ++this.num_sent) {
        this.bar.value = this.num_sent / this.files.length;
        this.summary.textContent = `${this.num_sent} of ${this.files.length} have come`;
        if (this.is_canceled) return;
        await post_file(url_of(kPost, { folder: this.folder, name: this.names[this.num_sent] }), this.files[this.num_sent]!.file);
      }
      this.bar.value = 1;
      this.summary.textContent = `All ${this.files.length} have come. Looking at them ...`;
      await this.look();
    } catch (error) {
      this.fail(error);
    }
  }

  private async look(): Promise<void> {
    const { id } = JSON.parse(await (await post(kJobs, { command: "init", arguments: { FOLDER: this.folder } })).text()) as { id: number };
    const job = await job_end(id);
    void jobs_panel.look();
    if (this.is_canceled) return;
    if (job.place !== null) {
      this.dialog.close();
      location.hash = `#/${encodeURIComponent(job.place)}`;
      return;
    }
    const folder = this.folder;
    replace(this.summary, `They are in ${folder}, but no capture could be drafted:`);
    this.problem.textContent = job.messages.map((line) => line.replace(/^patinate: /, "")).join("\n");
    this.accept.replaceWith(button("Draft it differently", () => { this.dialog.close(); start_job("init", { FOLDER: folder }); }, { kind: "primary" }));
  }
}

/// @param files  Those that were dropped on the page.
export async function open_photographs(files: ChosenFile[] = []): Promise<void> {
  try {
    const [{ photographs }, { places }] = await Promise.all([get_json<JobCommands>("/api/commands"), get_places()]);
    new PhotographsDialog(new Set([...photographs, ...places.map(({ place }) => place.split("/")[0]!)]), photographs.length).take(files);
  } catch (error) {
    show_error(error, kPost);
  }
}
