// The run as data: how many rows of which set, the CSV of docs/formats.md, rows kept out, notes, the way to a fit.
import { useState } from 'preact/hooks';
import { dataApi } from '@/api/data';
import { PointSet, type Run } from '@/api/gen/driftwise/v1/run_pb';
import { count, countRows, fixed } from '@/format/numbers';
import type { RunPoints } from '@/live/points';
import { Button } from '@/ui/button';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { download } from '@/ui/download';
import { useCommand } from '@/ui/use_command';
import { Exclusions } from './exclusions';
import { Notes } from './notes';

function ExportCsv({ run, withoutExcluded, children }: { run: Run; withoutExcluded: boolean; children: string }) {
  const [share, setShare] = useState(0);
  const fetchIt = useCommand(async () => {
    const chunks: BlobPart[] = [];
    let bytes = 0;
    for await (const piece of dataApi().exportDataset({ runIds: [run.id], withoutExcluded })) {
      chunks.push(piece.chunk as Uint8Array<ArrayBuffer>);
      bytes += piece.chunk.length;
      setShare(bytes / Math.max(1, Number(piece.totalBytes)));
    }
    download(`run-${run.id}.csv`, new Blob(chunks, { type: 'text/csv' }));
  }, 'reads');
  return (
    <>
      <Button busy={fetchIt.busy} onPress={() => void fetchIt.send()}>{fetchIt.busy ? `Exporting, ${fixed(share * 100)} %` : children}</Button>
      {fetchIt.failure && <Failed asked="Export the dataset" failure={fetchIt.failure} />}
    </>
  );
}

export function DatasetTab({ run, points }: { run: Run; points: RunPoints }) {
  const of = (set: PointSet) => points.points.filter((point) => point.set === set).length;
  const channels = points.points[0]?.values.map((one) => one.channel) ?? [];
  return (
    <div class="columns">
      <Panel title="Dataset">
        <div class="stack">
          <dl class="facts">
            <dt>calibration</dt><dd>{countRows(of(PointSet.CALIBRATION))}</dd>
            <dt>validation</dt><dd>{countRows(of(PointSet.VALIDATION))}</dd>
            <dt>returns to zero</dt><dd>{count(points.points.filter((point) => point.zero).length)}</dd>
            {points.passages.length > 0 && <><dt>passages</dt><dd>{countRows(points.passages.length)} beside the plan</dd></>}
            <dt>channels</dt><dd>{channels.length > 0 ? channels.join(', ') : '–'}</dd>
          </dl>
          <div class="actions">
            <ExportCsv run={run} withoutExcluded={false}>Export CSV</ExportCsv>
            <ExportCsv run={run} withoutExcluded>Export without rows kept out</ExportCsv>
          </div>
          <p><a href={`/models?run=${run.id}`}>Fit a model to this run</a> · <a href={`/diagnosis?run=${run.id}`}>Diagnose it</a></p>
        </div>
      </Panel>
      <Exclusions run={run} />
      <Notes run={run} />
    </div>
  );
}
