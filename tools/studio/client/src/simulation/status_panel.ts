// Numbers of the run: counters and where all mass is.
import type { Status } from "../types";
import { number_text, section } from "../ui/controls";
import { h, replace } from "../ui/dom";

const kColumns = ["emitted", "made", "on_surfaces", "carried", "absorbed", "rested", "left", "used"] as const;

export class StatusPanel {
  readonly element: HTMLDetailsElement;
  private readonly counters = h("dl", { class: "facts" });
  private readonly ledger = h("div", { class: "ledger-box", tabindex: 0, role: "region", "aria-label": "Mass ledger" });
  private status: Status | undefined;
  private readonly verdict = h("p", { class: "hint" });

  constructor() {
    this.element = section("Counters and mass", false, this.counters, h("h3", {}, "Mass ledger"), this.ledger, this.verdict);
    this.element.addEventListener("toggle", () => this.fill());
  }

  show(status: Status): void {
    this.status = status;
    this.fill();
  }

  // Only while it can be seen; a paused scene says nothing new when it is opened.
  private fill(): void {
    const { status } = this;
    if (!status || !this.element.open) return;
    const facts: [string, string][] = [...Object.entries(status.counters).map(([name, value]) => [name, number_text(value)] as [string, string]),
      ["memory of the server", `${Math.round(status.memory_mb)} MB`], ["browsers here", String(status.clients)]];
    replace(this.counters, facts.map(([label, text]) => [h("dt", {}, label), h("dd", {}, text)]).flat());
    const rows = Object.values(status.ledger);
    replace(this.ledger, h("table", { class: "ledger" }, h("thead", {}, h("tr", {}, h("th", { scope: "col" }, ""), Object.keys(status.ledger).map((material) => h("th", { scope: "col" }, material)))),
      h("tbody", {}, kColumns.map((column) => h("tr", {}, h("th", { scope: "row" }, column.replace("_", " ")), rows.map((row) => h("td", {}, number_text(row[column]))))))));
    const worst = Math.max(0, ...rows.map((row) => Math.abs(row.residual)));
    this.verdict.textContent = worst === 0 ? "Balances exactly: emitted and made = all the rest." : `Does not balance by ${number_text(worst)}: please report this.`;
  }
}
