// Which rows a fit or a study reads: runs, marked in the address (?run=1,2), or a file of the person's own. Without a word the
// newest run that has points when the page was opened: one that ends meanwhile is offered and changes nothing.
import { useState } from 'preact/hooks';
import { query, setQuery } from '@/app/router';
import { count } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { useRuns, type Runs } from '@/parts/runs';
import { Button } from '@/ui/button';
import { FileInput } from '@/ui/file_input';
import { Failed } from '@/ui/states';

export interface DataChoice {
  runs: Runs;
  chosen: readonly string[]; // ids of runs; none while a file is chosen
  file: { name: string; bytes: Uint8Array } | undefined;
  setFile: (file: { name: string; bytes: Uint8Array } | undefined) => void;
  data: { runIds: bigint[]; csv?: Uint8Array };
  missing: boolean; // nothing is chosen
  words: string; // "run 1"
}

export function useDataChoice(): DataChoice {
  const wanted = query('run');
  const runs = useRuns(wanted?.split(','));
  const [file, setFile] = useState<{ name: string; bytes: Uint8Array }>();
  const { newest } = runs;
  const chosen = file || wanted === 'none' ? []
    : wanted ? wanted.split(',').filter((id) => /^\d+$/.test(id))
    : newest ? [String(newest.id)] : [];
  return {
    runs, chosen, file, setFile,
    data: file ? { runIds: [], csv: file.bytes } : { runIds: chosen.map(BigInt) },
    missing: !file && chosen.length === 0,
    words: file ? file.name : chosen.length ? `${chosen.length === 1 ? 'run' : 'runs'} ${chosen.join(', ')}` : 'choose runs',
  };
}

export function DataFields({ choice, label }: { choice: DataChoice; label: string }) {
  const { runs, chosen, file, setFile } = choice;
  const known = runs.value?.filter((run) => run.acceptedCount > 0n || chosen.includes(String(run.id))) ?? [];
  const toggle = (id: string) => {
    const next = chosen.includes(id) ? chosen.filter((one) => one !== id) : [...chosen, id];
    setQuery({ run: next.length ? next.join(',') : 'none' });
  };
  return (
    <div class="row models-data">
      <details class="models-runs">
        <summary>data: {choice.words}</summary>
        <fieldset disabled={file !== undefined}>
          <legend class="sr-only">{label}</legend>
          {known.map((run) => (
            <label key={String(run.id)} class="models-run">
              <input type="checkbox" checked={chosen.includes(String(run.id))} onChange={() => toggle(String(run.id))} />
              <span>run {String(run.id)} {run.name}</span>
              <span class="note muted">{count(run.acceptedCount)} points, {dateClock(ms(run.startTime))}</span>
            </label>
          ))}
          {runs.value && known.length === 0 && <p class="muted">No run has points yet. <a href="/trajectories">Start one</a>, or take a file.</p>}
          {runs.value && !runs.isAll && <p><Button small busy={runs.asking} onPress={() => void runs.older()}>Load older runs</Button></p>}
        </fieldset>
        {runs.failure && <Failed asked="List the runs" failure={runs.failure} again={runs.again} />}
      </details>
      <FileInput label="or a dataset, CSV" accept=".csv,text/csv" chosen={file?.name} onFile={setFile} onClear={() => setFile(undefined)} mostBytes={32 << 20} />
    </div>
  );
}
