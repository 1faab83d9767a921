// Runs of one trajectory in different set-ups as one dataset: first the report, then the joined run.
import { useMemo, useState } from 'preact/hooks';
import { dataApi } from '@/api/data';
import { go } from '@/app/router';
import { count, countRows } from '@/format/numbers';
import { Button, CommandButton } from '@/ui/button';
import { Panel } from '@/ui/panel';
import { Failed, Warned } from '@/ui/states';
import { Table } from '@/ui/table';
import { useCommand } from '@/ui/use_command';
import { joinReport, medianOf, sigmaOf, uOf, type JoinedChannel, type JoinReport } from './join_report';

const digits = (value: number | undefined, unit: string): string => (value === undefined ? '–' : `${value.toPrecision(3)} ${unit}`);

function Report({ report }: { report: JoinReport }) {
  const judged = report.channels.filter((channel) => uOf(channel) !== undefined);
  return (
    <>
      <p>
        {countRows(report.rows)} joined{report.unmatched_rows > 0 && `, ${count(report.unmatched_rows)} left out`}.
        {report.temperature_difference_k !== undefined && ` Temperatures of the datums: at most ${report.temperature_difference_k.toPrecision(3)} K apart (${report.temperature_channel}).`}
        {report.zero_difference_nm !== undefined && ` Motor coordinates at pose zero: at most ${report.zero_difference_nm.toPrecision(3)} nm apart.`}
      </p>
      <Table<JoinedChannel>
        caption="Coordinates of the joined dataset"
        rows={judged}
        keyOf={(channel) => channel.channel}
        columns={[
          { title: 'coordinate', of: (channel) => channel.channel },
          { title: 'from', of: (channel) => channel.sources.join(', ') },
          { title: 'u of the join', number: true, of: (channel) => digits(uOf(channel), channel.unit) },
          { title: 'median of difference', number: true, of: (channel) => digits(medianOf(channel), channel.unit) },
          { title: 'sigma', number: true, of: (channel) => digits(sigmaOf(channel), channel.unit) },
        ]}
      />
      {report.warnings.map((warning) => <Warned key={warning}>{warning}</Warned>)}
    </>
  );
}

export function JoinPanel({ runs, onClose }: { runs: readonly bigint[]; onClose: () => void }) {
  const [report, setReport] = useState<{ of: string; report: JoinReport | undefined }>();
  const [returns, setReturns] = useState(false);
  const asked = `${runs.join(', ')}${returns ? ', returns subtracted' : ''}`;
  const request = { runIds: [...runs], subtractReturns: returns };
  const check = useCommand(async () => {
    const answer = await dataApi().joinRuns({ ...request, dryRun: true });
    setReport({ of: asked, report: joinReport(answer.reportJson) });
  }, 'reads');
  const requestId = useMemo(() => crypto.randomUUID?.() ?? '', [asked]); // a second press is the same run
  const join = useCommand(async () => {
    const { run } = await dataApi().joinRuns({ ...request, requestId });
    if (run) go(`/runs/${run.id}`);
  });
  const few = runs.length < 2 ? 'Choose two runs of one trajectory at least' : undefined;
  return (
    <Panel title="Join runs">
      <p>{runs.length === 0 ? 'Choose runs of one trajectory that were measured in different set-ups.' : `Runs ${runs.join(', ')}, row by row, as one dataset.`}</p>
      <label><input type="checkbox" checked={returns} onChange={(event) => setReturns(event.currentTarget.checked)} /> Subtract the returns to zero</label>
      <p class="more">
        <Button busy={check.busy} off={few} onPress={() => void check.send()}>Check</Button>{' '}
        <CommandButton kind="main" busy={join.busy} off={few} onPress={() => void join.send()}>Join</CommandButton>{' '}
        <Button onPress={onClose}>Close</Button>
      </p>
      {check.failure && <Failed asked="Check the join" failure={check.failure} />}
      {join.failure && <Failed asked="Join the runs" failure={join.failure} />}
      {report?.of === asked && report.report && <Report report={report.report} />}
    </Panel>
  );
}
