// Joints and tubes by their names in the catalogue, ratings beside: another one is a choice away.

import { Card, Select, DataTable } from "./Card";
import { formatNumber, withDecimalSign } from "./format";
import { store, type AppState } from "./store";
import { t } from "./i18n";
import type { ShownLine } from "./Drawing";

export function PartsTable({ known, shown }: { known: AppState; shown: ShownLine }) {
  const { line, marks } = shown;
  const { joints, tubes } = known.catalogue;
  // One name may stand for every joint of the line.
  const alike = new Set(line.joint_at).size === 1;
  const listed = alike ? line.joints.slice(0, 1) : line.joints;
  return (
    <Card id="parts" title={t("Parts")} note={t("of the catalogue, with their ratings")}>
      <DataTable label={t("Parts")} head={[t("part"), t("size"), [t("elastic limit")], [t("fatigue")], [t("bearings")]]}>
        {listed.map((name, k) => {
          const rated = joints.find((j) => j.name === name);
          const part = alike && line.joints.length > 1 ? t("every joint") : t("joint {n}", { n: k + 1 });
          return (
            <tr key={`j${k}`}>
              <th scope="row" class={marks[`joint ${k + 1}`] ?? ""}>{part}</th>
              <td><Choice at={line.joint_at[k]} now={line.joint_now[k] || name} label={part} of={joints.map((j) => [j.name, `${j.name} · ${j.series}`])} /></td>
              {[rated?.peak_Nm, rated?.reversing_Nm, rated?.bearing_Nm].map((torque, c) => <td key={c} class="n">{rated && (torque ? `${formatNumber(torque)} N·m` : "–")}</td>)}
            </tr>
          );
        })}
        {line.tube_names.map((size, k) => {
          const part = t("tube of shaft {n}", { n: k + 1 });
          return (
            <tr key={`t${k}`}>
              <th scope="row">{part}</th>
              <td><Choice at={line.tube_at[k]} now={line.tube_now[k] || size} label={part} of={tubes.map((c) => [c.name, [c.outer_mm, c.wall_mm].map(String).map(withDecimalSign).join(" × ")])} /></td>
              <td class="n" colSpan={3}>{size && `${size} mm`}</td>
            </tr>
          );
        })}
      </DataTable>
    </Card>
  );
}

function Choice({ at, now, label, of }: { at: string | undefined; now: string; label: string; of: [string, string][] }) {
  if (!at) return <span>{now || "–"}</span>;
  const known = of.some(([name]) => name === now);
  return <Select label={label} value={now} data-part={at} choose={(to) => store.apply({ [at]: to })} of={known ? of : [[now, now || "–"], ...of]} />;
}
