// What a chapter of a report says: tables, texts, figures as the report has them.

import type { Block } from "./types";

export function ReportBlocks({ of }: { of: Block[] }) {
  return (
    <div class="blocks">
      {of.map((b, k) => {
        if (b.kind === "text") return b.paragraphs.map((p) => <p key={p} class="note">{p}</p>);
        if (b.kind === "figure") return (
          <figure key={k} class="paper">
            <img src={`data:image/svg+xml,${encodeURIComponent(b.svg)}`} alt={b.alt} />
            <figcaption>{b.title}{b.note && <span class="note">. {b.note}</span>}</figcaption>
          </figure>
        );
        return (
          <div key={k} class="scroll" tabindex={0} role="region" aria-label={b.caption}>
            <table class="rows">
              <caption>{b.caption}</caption>
              <thead><tr>{b.head.map((h, c) => <th key={c} scope="col" class={c < b.words ? "" : "n"}>{h}</th>)}</tr></thead>
              <tbody>{b.rows.map((row, r) => <tr key={r}>{row.map((cell, c) => <td key={c} class={c < b.words ? "" : "n"}>{b.grades[r]?.[c] ? <b class={b.grades[r]?.[c]}>{cell}</b> : cell}</td>)}</tr>)}</tbody>
            </table>
          </div>
        );
      })}
    </div>
  );
}
