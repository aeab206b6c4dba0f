// Limits by states: the margin as colour and number; a click shows what it is about.

import { Fragment } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { Card, DataTable } from "./Card";
import { formatNumber, formatPercent, marginText } from "./format";
import { GRADES, gradeText } from "./gradeLookup";
import { store, worstPart, type AppState } from "./store";
import { t } from "./i18n";
import type { Full, Limit, Row } from "./types";
import { memoised } from "./hooks";

type Any = Row | (Limit & { values?: undefined });

export function MarginHeatmap({ known }: { known: AppState }) {
  const live = known.live;
  if (!live) return null;
  const rows = store.rows();
  const several = live.lines.length > 1;
  return (
    <Card id="heat" title={t("Limits by state")} note={t("margin in %, where it is smallest")} head={<button class="plain" onClick={() => store.resort()}>{t("worst first")}</button>}>
      <div class="scroll" tabindex={0} role="region" aria-label={t("Limits by state")}>
        <table class="cells">
          <thead>
            <tr>
              <th scope="col">{t("limit")}</th>
              {live.states.map((s, k) => (<th key={s.name} scope="col" class={k === (known.asked.state ?? known.pose?.state) ? "now" : ""}><span>{s.said}</span></th>))}
            </tr>
          </thead>
          <tbody>
            {rows.map((row) => (
              <Fragment key={row.id}>
                <StillRow row={row} known={known} several={several} />
                {known.selected?.row === row.id && !known.selected.inStrip && <tr class="opened"><td colSpan={live.states.length + 1}><LimitDetail known={known} /></td></tr>}
              </Fragment>
            ))}
          </tbody>
        </table>
      </div>
      <Others full={known.full} />
    </Card>
  );
}

interface Of { row: Any; known: AppState; several: boolean }

/** What is seen of a row, state by state. */
const seen = (row: Row): string =>
  row.grades.map((of, s) => { const p = worstPart(row, s); return [p, of[p], formatPercent(row.margins[s]?.[p]), near(row.margins[s]?.[p])].join(); }).join(";");

/** Most rows look as they did while one thing is moved: those are not drawn again. */
const StillRow = memoised<Of>(HeatRow, ({ row, known, several }) => [
  row.id,
  row.name,
  row.values && seen(row),
  "points" in row && !known.settled,
  known.selected?.row === row.id ? `${known.selected.state} ${known.selected.inStrip}` : null,
  known.live?.states.length,
  several,
  known.lang,
]);

function HeatRow({ row, known, several }: Of) {
  const states = known.live?.states ?? [];
  const late = "points" in row && !known.settled;
  // Rows of one name may be of different parts.
  const asked = row.values ? row.parts.filter((_, p) => row.grades.some((of) => (of[p] ?? null) !== null)) : [];
  return (
    <tr class={`${row.values ? "" : "coming"} ${late ? "late" : ""}`}>
      <th scope="row" title={row.name}>
        {several && <i>{row.line}: </i>}
        {row.name}
        <small>{limitText(row)}{row.values && asked.length > 0 && asked.length < row.parts.length && `, ${asked.join(", ")}`}</small>
        {row.values && asked.length === 0 && <small>{t("Not evaluated")}</small>}
      </th>
      {states.map((s, k) => {
        if (!row.values) return <td key={s.name}><span class="cell none">…</span></td>;
        const p = worstPart(row, k);
        const grade = row.grades[k]?.[p] ?? null;
        if (p < 0 || grade === null) return <td key={s.name} />;
        const margin = row.margins[k]?.[p];
        const chosen = known.selected?.row === row.id && known.selected.state === k;
        const open = chosen && !known.selected?.inStrip;
        const part = row.parts[p] ?? "";
        return (
          <td key={s.name}>
            <button
              class={`cell ${GRADES[grade]} ${near(margin)} ${chosen ? "chosen" : ""}`}
              {...disclosed(open)}
              aria-label={`${row.name}, ${s.said}${part ? `, ${part}` : ""}: ${gradeText(GRADES[grade] ?? "fail")}, ${formatPercent(margin)} %`}
              onClick={() => store.look(open ? null : { row: row.id, state: k, part: p })}
            >
              {formatPercent(margin)}
            </button>
          </td>
        );
      })}
    </tr>
  );
}

/** How near to its limit what passes is: a shade more. */
const near = (margin: number | null | undefined): string =>
  margin !== null && margin !== undefined && margin < 0.1 ? "near" : "";

/** What a button that opens the detail of a limit says of itself to a screen reader. */
export const disclosed = (open: boolean) => ({ "aria-expanded": open, ...(open && { "aria-controls": "detail", onKeyDown: closeOnEscape }) });

function closeOnEscape(e: KeyboardEvent): void {
  if (e.key === "Escape") store.look(null);
}

/** "≥ " before a value that is known as a lower bound alone. */
export const atLeast = (row: Row, s: number, p: number): string => (row.bounds?.[s]?.[p] ? "≥ " : "");

export function limitText(row: Limit): string {
  const unit = row.unit ? ` ${row.unit}` : "";
  if (row.band) return `${t("outside")} ${formatNumber(row.band[0])} … ${formatNumber(row.band[1])}${unit}`;
  const sense = row.sense === "<=" ? "≤" : "≥";
  const both = [row.normal, row.maximum].filter((b) => b !== null).map((b) => formatNumber(b));
  return `${sense} ${both.join(" | ")}${unit}`;
}

function Others({ full }: { full: Full | null }) {
  if (!full) return null;
  const bad = full.others.filter((o) => o.grade !== "pass").slice(0, 12);
  const rest = full.others.length - bad.length;
  return (
    <>
      {full.others.length > 0 && (
        <details class="more" open={bad.length > 0}>
          <summary>{t("Vibration and stability")}</summary>
          <ul class="others">
            {bad.map((o, k) => (
              <li key={k} class={o.grade}>
                <b>{gradeText(o.grade)}</b> {o.name}, {o.where}: {formatNumber(o.value)} ({o.limit})
              </li>
            ))}
            {rest > 0 && <li>{t("{count} more that pass", { count: rest })}</li>}
          </ul>
        </details>
      )}
      {([[t("Not evaluated"), full.unanswered], [t("Notes"), full.notes]] as const).map(([said, of]) => of.length > 0 && (
        <details key={said} class="more" open={of === full.unanswered && full.verdict === "incomplete"}><summary>{said} ({of.length})</summary><ul>{of.map((u) => <li key={u}>{u}</li>)}</ul></details>
      ))}
    </>
  );
}

/** What a cell is about: its parts, the equation, the source of the limit. It opens in sight, and Escape closes it. */
export function LimitDetail({ known }: { known: AppState }) {
  const { selected, live } = known;
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => box.current?.scrollIntoView({ block: "nearest" }), [selected?.row, selected?.state, selected?.inStrip]);
  const row = store.rows().find((r) => r.id === selected?.row);
  if (!selected || !live || !row?.values) return null;
  const q = known.quantities[row.quantity];
  const state = live.states[selected.state];
  return (
    <div class="detailed" ref={box} onKeyDown={closeOnEscape}><Card id="detail" title={row.name} note={state?.said} head={<button class="plain" onClick={() => store.look(null)} aria-label={t("close")}>✕</button>}>
      <DataTable label={row.name} head={[t("part"), [t("value")], [t("limit")], [t("margin")]]}>
        {row.parts.map((part, p) => {
          const grade = row.grades[selected.state]?.[p];
          if (grade === null || grade === undefined) return null;
          return (
            <tr key={p} class={p === selected.part ? "chosen" : ""}>
              <th scope="row">
                <button class="link" onClick={() => store.look({ ...selected, part: p })}>
                  {part || t("line")}
                </button>
                {row.points?.[selected.state]?.[p] && <small>{row.points[selected.state]?.[p]}</small>}
              </th>
              <td class="n">{atLeast(row, selected.state, p)}{formatNumber(row.values[selected.state]?.[p])} {row.unit}</td>
              <td class="n">{limitText(row)}</td>
              <td class={`n ${GRADES[grade]}`}>{marginText(row.margins[selected.state]?.[p])}</td>
            </tr>
          );
        })}
      </DataTable>
      {q && (
        <dl>
          <dt>{t("Equation")}</dt>
          <dd class="equation">{q.symbol && !q.equation.startsWith(q.symbol) ? `${q.symbol}: ` : ""}{q.equation}</dd>
          {q.where.map(([symbol, meaning]) => (<dd key={symbol} class="where"><i>{symbol}</i> {meaning}</dd>))}
          {q.use && <><dt>{t("Limits of use")}</dt><dd>{q.use}</dd></>}
          <dt>{t("Source of the equation")}</dt><dd>{q.source}</dd>
          <dt>{t("Source of the limit")}</dt><dd>{row.source}</dd>
        </dl>
      )}
    </Card></div>
  );
}
