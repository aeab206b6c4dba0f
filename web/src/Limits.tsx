// The limits with their sources: another profile, or a deviation that somebody signs.

import { useEffect, useState } from "preact/hooks";
import { Card, Select, DataTable } from "./Card";
import { formatNumber } from "./format";
import { store, type Job, type AppState } from "./store";
import { t } from "./i18n";
import type { LimitsOf } from "./types";

const EMPTY = { normal: "", maximum: "", reason: "", by: "" };

export function Limits({ known }: { known: AppState }) {
  const [at, open] = useState<number | null>(null);
  const [form, set] = useState(EMPTY);
  useEffect(() => { if (!known.held) store.work("limits"); }, [known.history?.text, known.beside, known.held, known.lang]);
  const asked = known.jobs.limits as Job<LimitsOf> | undefined;
  const of = asked?.answer;
  const job = known.jobs.deviate as Job<{ draft: string }> | undefined;
  useEffect(() => {
    if (!job?.answer || job.running) return;
    store.taken("deviate", {});
    store.type(job.answer.draft, false);
    open(null);
  }, [job?.answer]);
  if (!of) return <p class="card note">{asked?.why || "…"}</p>;
  const wrong = new Set((job?.problems ?? []).map((p) => p.key));
  const field = (key: keyof typeof EMPTY, name: string) => (
    <label>{name}<input data-field={key} value={form[key]} aria-invalid={wrong.has(key)} maxLength={key === "reason" ? 1000 : 40} onInput={(e) => set({ ...form, [key]: e.currentTarget.value })} /></label>
  );
  return (
    <Card id="limits" title={t("Limits and their sources")} note={of.profile} head={of.plain && (
      <Select label={t("profile")} data-do="profile" value={of.named || "heavy-truck"} choose={(limits) => store.apply({ limits })} of={[...new Set([of.named, ...known.profiles])].filter(Boolean)} />
    )}>
      {job?.why && <p class="note fail" role="status">{job.why}</p>}
      <DataTable label={t("Limits and their sources")} head={[t("limit"), [t("recommended")], [t("limit")], t("in"), t("Source of the limit"), ""]}>
        {of.limits.map((m, k) => (
          <>
            <tr key={k} class={m.signed ? "differs" : ""}>
              <th scope="row">{m.name}{m.required && <small>{t("required")}</small>}</th>
              {m.band
                ? <td class="n" colSpan={2}>{t("outside")} {formatNumber(m.band[0])} … {formatNumber(m.band[1])} {m.unit}</td>
                : [m.normal, m.maximum].map((b, i) => <td key={i} class="n">{b === null ? "–" : `${m.sense === "<=" ? "≤" : "≥"} ${formatNumber(b)} ${m.unit}`}</td>)}
              <td>{m.states.join(", ")}</td>
              <td>{m.signed && <b class="warn">{t("deviation")} </b>}{m.source}</td>
              <td>{!m.band && <button aria-expanded={at === k} onClick={() => { set({ ...EMPTY, by: form.by, normal: m.normal === null ? "" : String(m.normal), maximum: m.maximum === null ? "" : String(m.maximum) }); open(at === k ? null : k); }}>{t("record a deviation")}</button>}</td>
            </tr>
            {at === k && (
              <tr key={`f${k}`}>
                <td colSpan={6}>
                  <div class="fields">
                    {field("normal", `${t("recommended")} [${m.unit}]`)}
                    {field("maximum", `${t("limit")} [${m.unit}]`)}
                    {field("reason", t("why"))}
                    {field("by", t("signed by"))}
                  </div>
                  <button data-do="sign" class="make" disabled={!form.reason.trim() || !form.by.trim()} onClick={() => store.work("deviate", { which: k, ...form })}>{t("sign the deviation")}</button>
                </td>
              </tr>
            )}
          </>
        ))}
      </DataTable>
    </Card>
  );
}
