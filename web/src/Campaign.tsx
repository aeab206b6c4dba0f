// A campaign of recordings: what its file names, each recording looked at, life and causes of the mix.

import { Card } from "./Card";
import { Editor } from "./Editor";
import { RecordingResult, ChannelList, roleNames, type FaultRule } from "./Recording";
import { JobButton } from "./SpeedView";
import { store, type Job, type AppState } from "./store";
import { t } from "./i18n";
import type { Campaign as Of, Heard, Lived } from "./types";
import { useRetainedState } from "./hooks";

export function Campaign({ known, of }: { known: AppState; of: Of }) {
  const [chosen, choose] = useRetainedState(`campaign/${known.file}`, 0);
  const at = Math.min(chosen, of.drives.length - 1);
  const drive = of.drives[at];
  const look = known.jobs.drive as Job<Heard> | undefined;
  const life = known.jobs.campaign as Job<Lived> | undefined;
  const heard = look?.answer?.name === drive?.name ? look?.answer : null;
  const rules = Object.fromEntries((["accept", "mask"] as const).flatMap((rule) => drive?.[rule].map((said): [string, FaultRule] => [said, rule]) ?? []));
  return (
    <div class="columns">
      <div class="left">
        <Card id="drives" title={t("Recordings")}>
          <ol>
            {of.drives.map((d, k) => (
              <li key={d.name}>
                <button class="link" data-drive={k} aria-pressed={k === at} onClick={() => { choose(k); store.work("drive", { drive: k }); }}>{d.name}</button> × {d.times}
                {d.more.map((said) => <small key={said} class="note">{said}</small>)}
              </li>
            ))}
          </ol>
          {look?.running && <p class="note" role="status">{t("reading …")}</p>}
          {look?.why && <p class="fail">{look.why}</p>}
        </Card>
        {heard && <ChannelList of={heard} between={[0, heard.seconds]} rules={rules} used={(c) => c.role !== ""} decide={(said, rule) => store.apply(Object.fromEntries(([[rules[said], "[-]"], [rule, "[+]"]] as const).flatMap(([of, how]) => (of ? [[`recordings[${at + 1}].${of}${how}`, said]] : []))))}>{(c) => <span class="note">{roleNames()[c.role]}</span>}</ChannelList>}
        <Editor known={known} />
      </div>
      <div class="right">
        <Card id="asks" title={t("Life and causes")} head={<JobButton job={life} name="campaign" word={t("evaluate")} stale={life?.of !== store.about({})} ask={() => store.work("campaign")} />}>
          <dl class="asked">{of.asked.flatMap(([what, said]) => [<dt key={what}>{what}</dt>, <dd key={said}>{said}</dd>])}</dl>
        </Card>
        {life?.answer && <RecordingResult of={life.answer} known={known} open={1} />}
      </div>
    </div>
  );
}
