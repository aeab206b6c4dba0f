// How the joints add up: squared angles head to tail, rings where the limits begin.

import { Card } from "./Card";
import { formatFixed } from "./format";
import { t } from "./i18n";
import type { ShownLine } from "./Drawing";
import type { AppState } from "./store";

const SIZE = 300;

export function Phasors({ known, shown }: { known: AppState; shown: ShownLine }) {
  const { line, state } = shown;
  const at = shown.free ? known.pose?.at : undefined;
  const ends = at?.phasors ?? line.phasors[state] ?? [];
  const sum = at ? at.equivalent : line.equivalent[state];
  const rings = (line.rings[state] ?? []).filter((r) => (r.radius ?? 0) > 0);
  const far = Math.max(0.05, ...ends.map(([x, y]) => Math.hypot(x, y)));
  const reach = 1.18 * Math.max(far, ...rings.map((r) => r.radius ?? 0).filter((r) => r < 3 * far));
  const s = (v: number): number => SIZE / 2 + (v / reach) * (SIZE / 2 - 8);
  const label = t("Sum of the joints: equivalent angle {angle} deg", { angle: formatFixed(sum, 3) });
  return (
    <Card id="phasors" title={t("Sum of the joints")} note={t("squared angles, deg²")}>
      <svg viewBox={`0 0 ${SIZE} ${SIZE}`} role="img" aria-label={label}>
        <defs>
          {["a", "sum"].map((id) => (
            <marker key={id} id={`tip-${id}`} class={`tip-${id}`} viewBox="0 0 10 10" refX="8.5" refY="5" markerWidth="7" markerHeight="7" markerUnits="userSpaceOnUse" orient="auto-start-reverse">
              <path d="M0 0.8L9.5 5L0 9.2z" />
            </marker>
          ))}
        </defs>
        <path class="axes" d={`M0 ${SIZE / 2}H${SIZE}M${SIZE / 2} 0V${SIZE}`} />
        {rings.map((r) => (<circle key={r.grade} class={`ring ${r.grade}`} cx={SIZE / 2} cy={SIZE / 2} r={((r.radius ?? 0) / reach) * (SIZE / 2 - 8)} />))}
        {ends.slice(1).map((end, k) => {
          const from = ends[k] ?? [0, 0];
          const short = Math.hypot(end[0] - from[0], end[1] - from[1]) < 0.03 * reach;
          return (
            <g key={k} class={`joint-${k % 6}`}>
              <line class="arrow" x1={s(from[0])} y1={s(-from[1])} x2={s(end[0])} y2={s(-end[1])} marker-end={short ? undefined : "url(#tip-a)"} />
              <text x={s((from[0] + end[0]) / 2) + 6} y={s(-(from[1] + end[1]) / 2) - 5}>{k + 1}</text>
            </g>
          );
        })}
        <line class="sum" x1={s(0)} y1={s(0)} x2={s(ends.at(-1)?.[0] ?? 0)} y2={s(-(ends.at(-1)?.[1] ?? 0))} marker-end="url(#tip-sum)" />
      </svg>
      <p class="figure"><b>{formatFixed(sum, 3)}°</b> {t("equivalent angle")}</p>
    </Card>
  );
}
