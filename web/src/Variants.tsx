// Variants of the file: pinned, named, laid behind the drawing, and held side by side.

import type { ComponentChild } from "preact";
import { useEffect } from "preact/hooks";
import { Card, Select, DataTable } from "./Card";
import { store, type Job, type AppState } from "./store";
import { t } from "./i18n";
import type { Compared } from "./types";

/** Pins what is shown, and chooses what is drawn behind it. */
export function KeepVariantButton({ known }: { known: AppState }) {
  return (
    <>
      <button data-do="pin" onClick={() => store.pin()}>{t("Keep as variant")}</button>
      {known.live && known.variants.length > 0 && (
        <Select label={t("Drawn behind")} data-do="behind" value={String(known.behind ?? "")} choose={(k) => store.lay(k === "" ? null : Number(k))} of={[["", t("nothing behind")], ...known.variants.map((v, k) => [String(k), v.name] as const)]} />
      )}
    </>
  );
}

export function Variants({ known }: { known: AppState }) {
  useEffect(() => {
    if (known.variants.length && !known.held) store.work("compare", { variants: known.variants });
  }, [known.variants, known.history?.text, known.beside, known.held, known.lang]);
  const job = known.jobs.compare as Job<Compared> | undefined;
  const of = job?.of === store.about({ variants: known.variants }) || known.held ? job?.answer : null;
  const why = job?.why;
  if (!known.variants.length) {
    return (
      <section class="card">
        <p class="note">{t("Keep a variant, change something: both are compared here.")}</p>
        <p class="note">{t("For example: keep the line as a variant, raise a centre bearing by 5 mm in the drawing, and come back.")}</p>
        <KeepVariantButton known={known} />
      </section>
    );
  }
  const names = [t("as shown"), ...known.variants.map((v) => v.name)];
  return (
    <Card id="variants" title={t("Variants side by side")} head={<KeepVariantButton known={known} />}>
      {why && <p class="note fail">{why}</p>}
      <VariantComparison
        of={of && of.variants.length === names.length ? of : null}
        head={names.map((name, k) => k === 0 ? name : (
          <>
            <input aria-label={t("name of variant {n}", { n: k })} value={name} maxLength={100} onChange={(e) => store.rename(k - 1, e.currentTarget.value)} />
            <button class="plain" data-do="take" onClick={() => store.type(known.variants[k - 1]?.text ?? "", false)}>{t("download")}</button>
            <button class="plain" aria-label={t("delete variant {n}", { n: k })} onClick={() => store.unpin(k - 1)}>✕</button>
          </>
        ))}
      />
    </Card>
  );
}

/** What variants say differently, and what it does. */
export function VariantComparison({ of, head }: { of: Compared | null; head: ComponentChild[] }) {
  return (
    <DataTable label={t("Variants side by side")} head={["", ...head]}>
      {of && (
        <>
          {of.variants[0]?.verdict && <tr><th scope="row">{t("Verdict")}</th>{of.variants.map((v, k) => <td key={k}><b class={v.verdict ?? ""}>{v.headline}</b> <small>{v.counted.fail}, {v.counted.warn}</small></td>)}</tr>}
          {of.differences.map((d) => <tr key={d.name} class="differs"><th scope="row">{d.name}</th>{d.values.map((v, k) => <td key={k}>{v}</td>)}</tr>)}
          {of.effects.map((e) => <tr key={e.name}><th scope="row">{e.name}</th>{e.values.map((v, k) => <td key={k} class={e.grades[k] ?? ""}>{v}</td>)}</tr>)}
        </>
      )}
    </DataTable>
  );
}
