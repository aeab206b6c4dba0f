// The folder as a library: what each file comes to; reports to take away; frozen revisions.

import { useEffect, useState } from "preact/hooks";
import { Card, Select } from "./Card";
import { marginText, showHiddenMarks } from "./format";
import { JobButton } from "./SpeedView";
import { store, type Job, type AppState } from "./store";
import { t } from "./i18n";
import type { Compared, Status } from "./types";
import { useRetainedState } from "./hooks";
import { VariantComparison } from "./Variants";

/** Files that are compared at once. */
const MOST = 12;

export function Library({ known }: { known: AppState }) {
  const [wanted, want] = useState("");
  const [ticked, tick] = useState<number[]>([]);
  useEffect(() => store.work("library", {}, ""), [known.files, known.history?.saved, known.beside, known.lang]);
  const job = known.jobs.library as Job<{ rows: Status[] }, { rows: Status[] }> | undefined;
  const rows = (job?.running ? job.part?.rows : job?.answer?.rows) ?? [];
  const bare = (s: string): string => s.toLowerCase().normalize("NFKD");
  const shown = rows.filter((r) => bare(`${r.name} ${r.title} ${r.verdict ?? ""} ${r.profile ?? ""}`).includes(bare(wanted)));
  const compare = known.jobs.compare as Job<Compared> | undefined;
  const asked = { files: ticked.slice(1), file: ticked[0] };
  return (
    <>
      <Card id="library" title={t("Files")} head={
        <>
          <input type="search" data-field="search" aria-label={t("search")} placeholder={t("search")} value={wanted} onInput={(e) => want(e.currentTarget.value)} />
          <button data-do="compare" disabled={ticked.length < 2 || ticked.length > MOST} onClick={() => store.work("compare", { files: asked.files }, "", asked.file)}>{t("compare what is ticked")}</button>
          {ticked.length > MOST && <span class="note warn" role="alert">{t("up to {count} files stand side by side: untick some", { count: MOST })}</span>}
          {(job?.running || job?.why) && <span class="note" role="status">{job.why || t("calculating …")}</span>}
        </>
      }>
        {known.files.length === 0 && <p class="note">{t("There is no application file in this folder; `cardan new` writes one.")}</p>}
        <ul>
          {shown.map((r) => (
            <li key={r.file}>
              <input type="checkbox" disabled={!r.verdict} aria-label={t("compare {file}", { file: showHiddenMarks(r.name) })} checked={ticked.includes(r.file)} onChange={() => tick(ticked.includes(r.file) ? ticked.filter((f) => f !== r.file) : [...ticked, r.file])} />
              <b class={r.verdict ?? (r.title ? "" : "fail")}>{r.verdict ? r.headline : r.title ? t("campaign") : t("unreadable")}</b>
              <span><button class="link" onClick={() => { store.open(r.file); store.show("line"); }}>{showHiddenMarks(r.name)}</button> {r.title}{r.draft && <i> · {t("not saved")}</i>}</span>
              <span class="note">{r.why || (r.worst && `${r.worst.name}, ${r.worst.where} ${marginText(r.worst.margin)}`)}</span>
            </li>
          ))}
        </ul>
      </Card>
      {compare?.answer && !compare.running && compare.of === store.about(asked, "") && (
        <section class="card" aria-label={t("Variants side by side")}>
          <VariantComparison of={compare.answer} head={compare.answer.variants.map((v) => showHiddenMarks(v.name))} />
        </section>
      )}
    </>
  );
}

/** What was clicked, as a script that does it again. */
function Script({ known }: { known: AppState }) {
  const saved = known.history?.saved ?? "";
  const line = known.asked.line ?? 0;
  const [hold] = useRetainedState<string[]>(`hold/${known.file}/${line}`, []);
  useEffect(() => store.work("script", { saved, line, hold }), [known.history?.text, known.beside, saved, line, hold, known.lang]);
  const of = (known.jobs.script as Job<{ script: string; commands: string[]; other: string[] }> | undefined)?.answer;
  if (!of) return null;
  return (
    <Card id="script" title={t("What was done, as a script")}>
      <pre tabindex={0} data-field="script">{of.script}</pre>
      <pre tabindex={0}>{of.commands.join("\n")}</pre>
      {of.other.length > 0 && <p class="note">{t("Changed too, not a number: save the file to see it")}: {of.other.join(", ")}</p>}
    </Card>
  );
}

/** What of this file goes out, and the files beside it. */
export const LibraryView = ({ known }: { known: AppState }) => <><Reports known={known} /><Library known={known} /></>;

function Reports({ known }: { known: AppState }) {
  const [lang, speak] = useState(known.lang);
  const [by, sign] = useState("");
  const [note, say] = useState("");
  const job = known.jobs.report as Job<{ name: string; media: string; data: string }> | undefined;
  const [kind, ask] = useState("html");
  useEffect(() => {
    if (!job?.answer || job.running) return;
    const { name, media, data } = job.answer;
    const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(new Blob([bytes], { type: media })), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    store.taken("report", {});
  }, [job?.answer]);
  return (
    <div class="columns">
      <div class="left"><Card id="reports" title={t("Reports")}>
        <div class="fields">
          <label>{t("Language")}<Select value={lang} choose={speak} of={known.languages} /></label>
          <label>{t("as")}<Select data-field="kind" value={kind} choose={ask} of={known.campaign ? ["html", "pdf", "json"] : ["html", "pdf", "xlsx", "json"]} /></label>
        </div>
        <JobButton job={job} name="report" word={t("create and download")} stale ask={() => store.work("report", { kind, lang })} />
      </Card><Script known={known} /></div>
      <div class="right"><Card id="revisions" title={t("Revisions")}>
        <div class="fields">
          <label>{t("signed by")}<input data-field="by" maxLength={100} value={by} onInput={(e) => sign(e.currentTarget.value)} /></label>
          <label>{t("why")}<input data-field="note" maxLength={300} value={note} onInput={(e) => say(e.currentTarget.value)} /></label>
        </div>
        <button data-do="freeze" disabled={!by.trim() || known.freezing} onClick={() => store.freeze(by, note)}>{t("release revision")}</button>
        <ol reversed class="proposals">
          {known.revisions.map((r) => (
            <li key={r.name} value={Number(r.name)}>{r.said} <button class="plain" onClick={() => { store.beside(`${r.name}: ${r.said}`.slice(0, 100), r.text); store.show("variants"); }}>{t("what changed since")}</button></li>
          ))}
        </ol>
      </Card></div>
    </div>
  );
}
