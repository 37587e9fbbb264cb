// What runs, what waits and what has ended, on every page.
import { get_json, post, url_of } from "../api";
import type { JobInfo } from "../types";
import { button, icon_button } from "../ui/controls";
import { h, replace, type Child } from "../ui/dom";
import { icon } from "../ui/icons";
import { notice, offer, settle, show_error } from "../ui/notices";
import { open_job } from "./job_form";

const kAbout = "/api/jobs", kCancel = "/api/jobs/cancel";
const kLook_ms = 600;
/// The event of the window when a job has ended.
export const kJobEnded = "patinate-job-ended";

const kStates: Record<JobInfo["state"], string> = { waiting: "waits", running: "runs", done: "done", failed: "failed", canceled: "canceled" };
const is_open_job = ({ state }: JobInfo): boolean => state === "waiting" || state === "running";
const is_picture = (name: string): boolean => /\.(png|jpe?g|gif)$/i.test(name);

function time_text(seconds: number): string {
  const whole = Math.round(seconds);
  return whole < 60 ? `${whole} s` : `${Math.floor(whole / 60)} min ${whole % 60} s`;
}

export function verb_of({ command }: JobInfo): string {
  const word = command.split(" ").pop()!;
  return word.charAt(0).toUpperCase() + word.slice(1);
}

class JobsPanel {
  readonly element = h("aside", { class: "jobs", "aria-label": "Jobs", hidden: true });
  readonly opener = h("button", { type: "button", class: "quiet jobs-opener", hidden: true, "aria-expanded": "false", onclick: () => this.show(this.element.hidden) });
  private readonly list = h("div", { class: "job-list" });
  private readonly cards = new Map<number, { card: HTMLElement; text: string }>();
  private jobs: JobInfo[] = [];
  private timer: number | undefined;
  private has_looked = false;

  constructor() {
    this.element.append(h("header", {}, h("h2", {}, "Jobs"), icon_button("close", "Close", () => this.show(false), "Esc")), this.list);
  }

  get is_open(): boolean { return !this.element.hidden; }

  show(is_shown: boolean): void {
    this.element.hidden = !is_shown;
    this.opener.setAttribute("aria-expanded", String(is_shown));
    if (is_shown) for (const { id } of this.jobs) settle(`job ${id}`);
  }

  /// A job has been started.
  started = (): void => {
    this.show(true);
    void this.look();
  };

  async look(): Promise<void> {
    window.clearTimeout(this.timer);
    try {
      const { jobs } = await get_json<{ jobs: JobInfo[] }>(kAbout);
      settle(kAbout);
      const before = this.jobs;
      this.jobs = jobs;
      this.render();
      for (const job of jobs) if (this.has_looked && !is_open_job(job) && before.some((old) => old.id === job.id && is_open_job(old))) this.tell(job);
      this.has_looked = true;
    } catch (error) {
      show_error(error, kAbout);
    }
    window.clearTimeout(this.timer);
    if (this.jobs.some(is_open_job)) this.timer = window.setTimeout(() => void this.look(), kLook_ms);
  }

  private tell(job: JobInfo): void {
    window.dispatchEvent(new CustomEvent(kJobEnded, { detail: job }));
    if (this.is_open || job.state === "canceled") return;
    const text = `${verb_of(job)}: ${job.output} ${job.state === "done" ? "is done" : "has failed"}.`;
    if (job.state !== "done") notice(text, "error");
    else if (job.place !== null) offer(text, "Open it", `job ${job.id}`, () => { location.hash = `#/${encodeURIComponent(job.place!)}`; }, () => {});
    else notice(text);
  }

  private render(): void {
    const num_open = this.jobs.filter(is_open_job).length;
    this.opener.hidden = this.jobs.length === 0;
    replace(this.opener, icon("jobs"), h("span", {}, num_open > 0 ? `${num_open} running` : "Jobs"));
    if (this.jobs.length === 0) this.show(false);
    for (const [id, { card }] of this.cards) {
      if (this.jobs.some((job) => job.id === id)) continue;
      card.remove();
      this.cards.delete(id);
    }
    // Only what has changed is made again, so that what is unfolded stays so.
    this.jobs.forEach((job, i) => {
      const { seconds, ...rest } = job, text = JSON.stringify(is_open_job(job) ? { ...rest, seconds: Math.round(seconds) } : rest), kept = this.cards.get(job.id);
      const card = kept && kept.text === text ? kept.card : this.card(job, kept?.card);
      if (kept && kept.card !== card) kept.card.replaceWith(card);
      this.cards.set(job.id, { card, text });
      if (this.list.children[i] !== card) this.list.insertBefore(card, this.list.children[i] ?? null);
    });
  }

  private card(job: JobInfo, before: HTMLElement | undefined): HTMLElement {
    const was_open = (name: string): boolean => before?.querySelector<HTMLDetailsElement>(`details.${name}`)?.open ?? false;
    // That it is done, its state says.
    const last = job.messages.filter((line) => job.state !== "done" || line.startsWith("warning: ")).pop();
    const details = (name: string, title: string, ...children: Child[]): HTMLElement => {
      const element = h("details", { class: name }, h("summary", {}, title), ...children);
      element.open = was_open(name);
      return element;
    };
    return h("article", { class: `job ${job.state}`, "aria-label": `${verb_of(job)}: ${job.output}`, "data-id": job.id },
      h("header", {}, h("b", {}, verb_of(job)), h("span", { class: "state" }, `${kStates[job.state]}${job.state === "waiting" ? "" : `, ${time_text(job.seconds)}`}`)),
      h("p", { class: "output" }, job.output),
      job.state === "running" && h("div", { class: "how-far" }, h("progress", { max: 1, value: job.share ?? undefined, "aria-label": job.stage || "Progress" }), h("span", {}, job.share === null ? "" : `${job.stage} ${Math.round(100 * job.share)} %${job.left ? `, ${job.left} left` : ""}`)),
      last && h("p", { class: job.state === "failed" ? "problem" : "last" }, last.replace(/^patinate: /, "")),
      job.is_file && is_picture(job.output) && h("img", { src: url_of("/api/jobs/file", { id: job.id }), alt: job.output }),
      h("div", { class: "actions" },
        is_open_job(job) && button("Cancel", () => void post(kCancel, { id: job.id }).then(() => this.look()).catch((error: unknown) => show_error(error, kCancel)), { icon: "close" }),
        job.place !== null && h("a", { class: "button primary", href: `#/${encodeURIComponent(job.place)}` }, "Open"),
        job.is_file && (job.place === null || job.place === job.output) && h("a", { class: `button ${job.place === null ? "primary" : ""}`, href: url_of("/api/jobs/file", { id: job.id }), download: job.output.split("/").pop() }, icon("download"), "Download"),
        !is_open_job(job) && button(job.state === "done" ? "Do it differently" : "Try again", () => void open_job(job.command, job.arguments, this.started, job.state === "done" ? "" : job.output),
          { ...(job.state === "done" ? { kind: "quiet" as const } : {}), hint: "Opens the form with these values. What a canceled job has finished is used again" })),
      job.messages.length > 1 && details("messages", `${job.messages.length} messages`, h("ul", {}, job.messages.map((line) => h("li", {}, line)))),
      details("line", "Command", h("code", { class: "command" }, job.line), navigator.clipboard ? button("Copy", () => void navigator.clipboard.writeText(job.line).then(() => notice("The command was copied."), show_error), { kind: "quiet", icon: "copy" }) : null));
  }
}

export const jobs_panel = new JobsPanel();
