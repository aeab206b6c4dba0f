// What moving one thing would do to each limit that does not pass; a click makes the move.

import { Card } from "./Card";
import { formatNumber, formatPercent } from "./format";
import { store, type AppState } from "./store";
import { t } from "./i18n";

const SHOWN = 4;

export function Suggestions({ known }: { known: AppState }) {
  const { helps, helping, full } = known;
  if (!full) return null;
  return (
    <Card id="helps" title={t("Single corrections")} note={t("each move alone; click to apply")} head={<button class="plain" disabled={helping || !known.settled} onClick={() => store.help()}>{helping ? t("calculating …") : t("evaluate")}</button>}>
      {helps?.length === 0 && <p class="note">{t("Everything passes.")}</p>}
      {helps?.map((h, k) => (
        <div key={k} class="help">
          <p class={h.grade}><b>{h.name}</b> {h.where}: {formatNumber(h.value)} ({h.limit})</p>
          {h.bars.filter((b) => b.gain > 0.001).length === 0 && <p class="note">{t("no single correction")}</p>}
          <ul>
            {h.bars.filter((b) => b.gain > 0.001).slice(0, SHOWN).map((b) => (
              <li key={b.said}>
                <button onClick={() => store.apply(b.edits)} disabled={!Object.keys(b.edits).length}>
                  <span class="bar"><svg viewBox="0 0 100 6" preserveAspectRatio="none" aria-hidden="true"><rect width={Math.min(100, 100 * b.gain)} height={6} /></svg></span>
                  <span>{b.said}{b.spoilt && <small>{b.spoilt}</small>}</span>
                  <span class="n">{formatNumber(b.value)} {h.unit}</span>
                  <span class="n">{formatPercent(b.gain)} %</span>
                </button>
              </li>
            ))}
          </ul>
        </div>
      ))}
    </Card>
  );
}
