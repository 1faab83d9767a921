// The report of a run as a file: made by the daemon when the button is pressed (docs/web-report.md).
import { lazily } from '@/api/client';
import { RecordService } from '@/api/gen/driftwise/v1/record_service_pb';
import { CommandButton } from '@/ui/button';
import { download } from '@/ui/download';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';

const recordApi = lazily(RecordService);

export function ReportButton({ runId }: { runId: bigint }) {
  const report = useCommand(async () => {
    const pieces: BlobPart[] = [];
    for await (const piece of recordApi().getReport({ runId })) pieces.push(new Uint8Array(piece.data));
    download(`run-${runId}.html`, new Blob(pieces, { type: 'text/html;charset=utf-8' }));
  });
  return (
    <>
      <CommandButton small busy={report.busy} label={`Report of run ${runId}`} onPress={() => void report.send()}>Report</CommandButton>
      {report.failure && <Failed asked="Make the report" failure={report.failure} />}
    </>
  );
}
