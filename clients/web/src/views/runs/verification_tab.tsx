// The run against what was wanted, alone or against another run on the positions of both.
import { api } from '@/api/client';
import type { Run } from '@/api/gen/driftwise/v1/run_pb';
import { query, setQuery } from '@/app/router';
import { compensationText } from '@/parts/run_words';
import { VerificationTable } from '@/parts/verification';
import { AccuracyHeading, figure, meanFigure } from '@/ui/accuracy';
import { unitSign } from '@/format/units';
import { count } from '@/format/numbers';
import { Field } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';

export function VerificationTab({ run }: { run: Run }) {
  const typed = query('against') ?? '';
  const against = /^\d+$/.test(typed) && BigInt(typed) !== run.id ? BigInt(typed) : undefined;
  const runIds = against === undefined ? [run.id] : [run.id, against];
  const asked = useAsked(`verification ${runIds.join(' ')} ${run.acceptedCount}`, (signal) => api.run().verifyRuns({ runIds }, { signal }));
  const answer = asked.value;
  return (
    <Panel title={`Run ${run.id}, ${compensationText(run)}`}>
      <Field
        label="against run" value={typed} onInput={(text) => setQuery({ against: text || undefined })} hint="such as one without compensation; empty: none"
        {...(typed !== '' && against === undefined ? { wrong: 'the number of another run' } : {})}
      />
      {asked.failure && <Failed asked="Verify the run" failure={asked.failure} again={asked.again} />}
      {!answer && !asked.failure && <Awaiting what="the verification" />}
      {answer && (
        <>
          <AccuracyHeading of={answer.accuracy} />
          {answer.runs.map((one) => (
            <section key={String(one.run?.id)}>
              {answer.runs.length > 1 && <h3>Run {String(one.run?.id)}{one.run && `, ${compensationText(one.run)}`}</h3>}
              <VerificationTable run={String(one.run?.id)} of={{ rows: one.rowCount, outsideRows: one.outsideRowCount, zeroRows: one.zeroRowCount, outside: one.outside, coordinates: one.coordinates }} />
            </section>
          ))}
          {answer.changes.map((change) => (
            <section key={String(change.againstRunId)}>
              <h3>Run {String(change.runId)} against run {String(change.againstRunId)}</h3>
              <p class="note muted">{change.positionCount > 0n ? `on the ${count(change.positionCount)} positions that both visited` : 'no position in common: all points of each'}</p>
              <Table
                caption={`Run ${change.runId} against run ${change.againstRunId}`}
                rows={change.coordinates}
                keyOf={(one) => one.output}
                columns={[
                  { title: 'coordinate', of: (one) => one.output },
                  { title: `A90 of run ${change.againstRunId}`, number: true, of: (one) => `${figure(one.before?.a90)} ${unitSign(one.unit)}` },
                  { title: `of run ${change.runId}`, number: true, of: (one) => <strong>{figure(one.figures?.a90)} {unitSign(one.unit)}</strong> },
                  { title: 'mean', number: true, of: (one) => `${meanFigure(one.before?.mean, one.before?.a90)} → ${meanFigure(one.figures?.mean, one.figures?.a90)} ${unitSign(one.unit)}` },
                  { title: 'S90', number: true, of: (one) => `${figure(one.before?.u90)} → ${figure(one.figures?.u90)} ${unitSign(one.unit)}` },
                ]}
              />
            </section>
          ))}
        </>
      )}
    </Panel>
  );
}
