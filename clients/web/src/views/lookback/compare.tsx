// Runs over one axis of time.
import { useState } from 'preact/hooks';
import { query, setQuery } from '@/app/router';
import { fixed, signed } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { unitSign } from '@/format/units';
import { Plot } from '@/plot/plot';
import type { PlotSpec } from '@/plot/spec';
import { Field } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { lookBackApi } from '@/api/look_back';
import { overlays } from './specs';

const mostRuns = 8;

// "3, 4" -> [3n, 4n]; undefined: something else.
export function runsTyped(text: string): bigint[] | undefined {
  const words = text.split(/[\s,]+/).filter(Boolean);
  if (words.length > mostRuns || !words.every((word) => /^[1-9]\d{0,15}$/.test(word))) return undefined;
  return [...new Set(words)].map(BigInt);
}

const Plots = ({ specs }: { specs: readonly PlotSpec[] }) => <>{specs.map((spec) => <Plot key={spec.y.unit} spec={spec} />)}</>;

export function Compare() {
  const text = query('runs') ?? '';
  const modelText = query('model') ?? '';
  const [typed, setTyped] = useState(text);
  const runIds = runsTyped(text);
  const modelId = /^[1-9]\d{0,15}$/.test(modelText) ? BigInt(modelText) : undefined;
  const asked = useAsked(runIds?.length ? `compare ${runIds.join()} ${modelText}` : undefined, async (signal) =>
    lookBackApi().compareRuns({ runIds: runIds!, ...(modelId !== undefined && { modelId }) }, { signal }));
  const runs = asked.value?.runs;
  return (
    <Panel title="Runs side by side">
      <div class="filters">
        <Field label="Runs" value={typed} wrong={runIds ? undefined : 'Up to 8 numbers, like 3, 4'} onInput={(next) => { setTyped(next); setQuery({ runs: next || undefined }); }} />
        <Field label="Residuals of model" value={modelText} onInput={(model) => setQuery({ model: model || undefined })} />
      </div>
      {asked.failure && <Failed asked="Compare the runs" failure={asked.failure} again={asked.again} />}
      {!runIds?.length && <Empty>Name the runs to compare.</Empty>}
      {runIds && runIds.length > 0 && !runs && !asked.failure && <Awaiting what="the runs" />}
      {runs && (
        <>
          <Table
            caption="Drift of the zero, run by run"
            rows={runs.flatMap((run) => run.zero.map((one) => ({ run, one })))}
            keyOf={({ run, one }) => `${run.runId} ${one.name}`}
            columns={[
              { title: 'run', of: ({ run }) => <a href={`/runs/${run.runId}`}>{String(run.runId)} {run.name}</a> },
              { title: 'began', of: ({ run }) => dateClock(ms(run.startTime)) },
              { title: 'zero of', of: ({ one }) => one.name },
              { title: 'range', number: true, of: ({ one }) => `${fixed(one.range, 1)} ${unitSign(one.unit)}` },
              { title: 'per hour', number: true, of: ({ one }) => `${signed(one.ratePerH, 1)} ${unitSign(one.unit)}` },
            ]}
          />
          <Plots specs={overlays('Drift of the zero', runs, (run) => run.zero, 'No returns to zero.')} />
          <Plots specs={overlays('Temperatures', runs, (run) => run.temperatures, 'No temperatures.')} />
          {modelId !== undefined && <Plots specs={overlays('Residuals', runs, (run) => run.residuals, runs.map((run) => run.residualTrouble).find(Boolean) ?? 'No residuals.')} />}
        </>
      )}
    </Panel>
  );
}
