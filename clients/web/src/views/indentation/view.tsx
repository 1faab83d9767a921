// Indentation: a procedure that a client executes and reports. Its stages, contacts and corrections, the table of indents and the
// verdict, as the daemon has them.
import { IndentConformity, type GetIndentationResponse, type Indentation } from '@/api/gen/driftwise/v1/indentation_service_pb';
import { segments } from '@/app/router';
import { fixed, signed } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { cellTimeMs } from '@/live/state';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed, Warned } from '@/ui/states';
import { Table, type Column } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { useWhile } from '@/ui/use_while';
import { Verdict } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { indentationApi } from './api';
import { answerInWords, answers, recordFrom, tableFrom, type Contact, type IndentRow, type IndentTable, type Round } from './record';

const silentAfterMs = 10 * 60_000; // of cell time: an approach reports its contact within minutes

export default function IndentationView() {
  const asked = useAsked('indentations', (signal) => indentationApi().listIndentations({}, { signal }));
  const list = asked.value?.indentations;
  const named = segments.value[1];
  const chosen = named && /^\d{1,18}$/.test(named) ? BigInt(named) : list?.[0]?.id;
  useWhile(list?.some(isOpen) ?? true, asked, 5000);
  return (
    <>
      <ViewTitle sub="Two robots that touch: alignment, common zero, indents">Indentation</ViewTitle>
      {asked.failure && <Failed asked="List the indentations" failure={asked.failure} again={asked.again} />}
      {!list && !asked.failure && <Awaiting what="the indentations" />}
      {list && (
        <div class="stack">
          <Panel title="Indentations">
            {list.length === 0
              ? <Empty next="driftwise indent start indentation.toml">No indentation is on record.</Empty>
              : <Table caption="Indentations, newest first" rows={list} keyOf={(one) => String(one.id)} columns={listColumns} />}
          </Panel>
          {chosen !== undefined && <One key={String(chosen)} id={chosen} />}
        </div>
      )}
    </>
  );
}

const isOpen = (one: Indentation) => one.ended === '' && one.verdict === '';

const listColumns: Column<Indentation>[] = [
  { title: 'indentation', of: (one) => <a href={`/indentation/${one.id}`}>{String(one.id)}</a> },
  { title: 'name', of: (one) => one.name },
  { title: 'tool', of: (one) => one.tool },
  { title: 'begun', of: (one) => <span class="nowrap">{dateClock(ms(one.createTime))} by {one.createdBy}</span> },
  { title: 'contacts', number: true, of: (one) => String(one.contactCount) },
  { title: 'indents', of: (one) => `${one.indentCount} of ${one.plannedIndentCount}` },
  { title: 'state', of: (one) => <State one={one} /> },
];

const conformityKind = {
  [IndentConformity.UNSPECIFIED]: 'idle', [IndentConformity.WITHIN]: 'good', [IndentConformity.BEYOND]: 'bad', [IndentConformity.UNDECIDED]: 'warn',
} as const;
const conformityWords = {
  [IndentConformity.UNSPECIFIED]: 'not judged',
  [IndentConformity.WITHIN]: 'wanted accuracy reached',
  [IndentConformity.BEYOND]: 'wanted accuracy not reached',
  [IndentConformity.UNDECIDED]: 'pictures cannot tell',
} as const;

function State({ one }: { one: Indentation }) {
  if (one.verdict) return <Verdict kind={conformityKind[one.conformity]}>{conformityWords[one.conformity]}</Verdict>;
  if (one.stage === 'microscope') return <Verdict kind="warn">awaits the microscope's table</Verdict>;
  return one.ended ? <Verdict kind="warn">ended at {one.stage}</Verdict> : <Verdict kind="idle">{one.stage} under way</Verdict>;
}

function One({ id }: { id: bigint }) {
  const asked = useAsked(`indentation ${id}`, (signal) => indentationApi().getIndentation({ indentationId: id }, { signal }));
  const one = asked.value?.indentation;
  useWhile(one !== undefined && isOpen(one), asked, 3000);
  if (asked.failure) return <Failed asked={`Show indentation ${id}`} failure={asked.failure} again={asked.again} />;
  if (!asked.value || !one) return <Awaiting what="the indentation" />;
  const record = recordFrom(asked.value.recordJson);
  return (
    <>
      <Stages one={one} corrections={record?.corrections ?? 0} />
      {!record && <Warned>The record of this indentation is of another version: driftwise indent show {String(id)} --json prints it.</Warned>}
      {record && record.rounds.length > 0 && (
        <Panel title="Corrections"><Table caption="Rounds of the alignment" rows={record.rounds} keyOf={(round) => round.round} columns={roundColumns} /></Panel>
      )}
      {record && record.contact_list.length > 0 && <Contacts contacts={record.contact_list} />}
      <Indents answer={asked.value} />
      {record && (
        <Panel title="Log"><ol>{record.log.map((line, at) => <li key={at}>{line}</li>)}</ol></Panel>
      )}
    </>
  );
}

const stages = ['align', 'zero', 'indents', 'microscope'];
const what = {
  align: 'three places are touched, the robot below is tilted, shifted places are touched',
  zero: 'contact at the common zero of both robots',
  indents: 'closed loop first, then open loop along both lines',
  microscope: 'its table is imported: driftwise indent import indentation.toml microscope.csv',
} as Record<string, string>;

function Stages({ one, corrections }: { one: Indentation; corrections: number }) {
  const at = stages.indexOf(one.stage);
  const figures: Record<string, string> = { align: `${corrections} ${corrections === 1 ? 'correction' : 'corrections'}`, indents: `${one.indentCount} of ${one.plannedIndentCount}` };
  const now = cellTimeMs.value;
  const reported = ms(one.reportTime);
  const isSilent = isOpen(one) && at < 3 && now !== undefined && reported !== undefined && now - reported > silentAfterMs;
  return (
    <Panel title={`Indentation ${one.id}: ${one.name}, tool ${one.tool}`}>
      <Table
        caption="Stages"
        rows={stages}
        keyOf={(stage) => stage}
        columns={[
          { title: 'stage', of: (stage) => stage },
          { title: 'what happens', of: (stage) => what[stage] },
          { title: 'state', of: (stage) => stageState(stages.indexOf(stage), at, one) },
          { title: 'figures', of: (stage) => figures[stage] ?? '–' },
        ]}
      />
      <p class="muted">Last report {dateClock(reported)}.</p>
      {one.ended && <p>The client ended: {one.ended}</p>}
      {isSilent && <Warned>No report for {fixed((now - reported) / 60_000)} min: the client may be lost. driftwise indent start with the same file retracts first, and continues.</Warned>}
      {one.inContact && <Warned>In contact at the last report.</Warned>}
    </Panel>
  );
}

function stageState(stage: number, at: number, one: Indentation) {
  if (stage < at || (stage === 3 && one.verdict)) return <Verdict kind="good">done</Verdict>;
  if (stage > at) return <span class="muted">to come</span>;
  return one.ended && stage < 3 ? <Verdict kind="warn">ended</Verdict> : <Verdict kind="idle">next</Verdict>;
}

const utc = (iso: string) => (iso ? dateClock(Date.parse(iso)) : '–');

const roundColumns: Column<Round>[] = [
  { title: 'round', of: (one) => String(one.round + 1) },
  { title: 'time', of: (one) => <span class="nowrap">{utc(one.at)}</span> },
  { title: 'contacts agree to, nm', number: true, of: (one) => fixed(one.spread_nm) },
  { title: 'answer', of: (one) => (one.accepted ? <Verdict kind="good">accepted</Verdict> : 'corrected to') },
  { title: 'rx, arcsec', number: true, of: (one) => signed(one.rx_arcsec, 1) },
  { title: 'ry, arcsec', number: true, of: (one) => signed(one.ry_arcsec, 1) },
  { title: 'model', of: (one) => <AnsweredBy by={one.by} /> },
];

const contactColumns: Column<Contact>[] = [
  { title: 'contact', of: (one) => String(one.contact) },
  { title: 'time', of: (one) => <span class="nowrap">{utc(one.at)}</span> },
  { title: 'for', of: (one) => (one.indent ? `indent ${one.indent}` : one.stage) },
  { title: 'x, mm', number: true, of: (one) => place(one, one.x_mm) },
  { title: 'y, mm', number: true, of: (one) => place(one, one.y_mm) },
  { title: 'height, mm', number: true, of: (one) => (one.trouble ? '–' : fixed(one.height_mm, 6)) },
  { title: 'u, nm', number: true, of: (one) => (one.trouble ? '–' : fixed(one.u_nm)) },
  { title: 'steps', number: true, of: (one) => (one.trouble ? '–' : String(one.steps)) },
  { title: 'outcome', of: (one) => (one.trouble ? <Verdict kind="bad">{one.trouble}</Verdict> : 'found') },
];

function AnsweredBy({ by }: { by: string }) {
  return <>{answerInWords(by).who}</>;
}
function Doubts({ by }: { by: string }) {
  return <>{answerInWords(by).doubts.map((words) => <div key={words}><Verdict kind="warn">{words}</Verdict></div>)}</>;
}

const place = (one: Contact, value: number) => (one.trouble ? '–' : fixed(value, 3));

function Contacts({ contacts }: { contacts: readonly Contact[] }) {
  return (
    <Panel title="Contacts">
      <Table caption="Contacts on the substrate" rows={contacts} keyOf={(one) => one.contact} columns={contactColumns} />
      <h3>Motor coordinates of the contacts</h3>
      <ul>{answers(contacts).map((one) => <li key={one.by}><AnsweredBy by={one.by} />: contacts {one.contacts}<Doubts by={one.by} /></li>)}</ul>
    </Panel>
  );
}

const um = (title: string, of: (row: IndentRow) => string): Column<IndentRow> => ({ title, number: true, of });
const indentColumns: Column<IndentRow>[] = [
  { title: 'indent', of: (row) => row.id },
  { title: 'line', of: (row) => row.line },
  um('wanted, µm', (row) => fixed(row.wanted_um, 0)),
  um('rx, arcsec', (row) => signed(row.rx_arcsec, 1)),
  um('ry, arcsec', (row) => signed(row.ry_arcsec, 1)),
  um('measured, µm', (row) => fixed(row.measured_um, 2)),
  um('U, µm', (row) => fixed(row.half_width_um, 2)),
  um('u, µm', (row) => fixed(row.u_um, 2)),
  um('error, µm', (row) => signed(row.error_um, 2)),
  um('of it rigid lever', (row) => signed(row.lever_um, 2)),
  um('rest, µm', (row) => signed(row.rest_um, 2)),
  um('force, mN', (row) => fixed(row.force_mN, 0)),
];

function Indents({ answer }: { answer: GetIndentationResponse }) {
  const table = answer.tableJson ? tableFrom(answer.tableJson) : undefined;
  if (!table) return answer.tableTrouble ? <Panel title="Table of indents"><Warned>{answer.tableTrouble}</Warned></Panel> : null;
  return (
    <Panel title="Table of indents">
      <Table caption="Indents against what was wanted" rows={table.indents} keyOf={(row) => row.id} columns={indentColumns} />
      <p class="muted">U = 2 m p + k p / 2, half-widths added; u by the GUM; lever {fixed(table.lever_mm, 0)} mm.</p>
      <Judged table={table} conformity={answer.indentation?.conformity ?? IndentConformity.UNSPECIFIED} />
    </Panel>
  );
}

function Judged({ table, conformity }: { table: IndentTable; conformity: IndentConformity }) {
  return (
    <div class="stack">
      {table.lines.map((fit) => (
        <p key={fit.line}>
          Line {fit.line}: rms {fixed(fit.rms_um, 3)} µm; lever factor {fixed(fit.lever_factor, 2)} ± {fixed(fit.u_lever_factor, 2)}, scale {signed(fit.scale_ppm / 1e4, 2)} ± {fixed(fit.u_scale_ppm / 1e4, 2)} %,
          correlation of the two {fixed(fit.correlation, 4)}.
        </p>
      ))}
      {table.indistinguishable.length > 0 && (
        <>
          <p>Cannot be told apart by these indents: {table.indistinguishable.join(', ')}. Measurements that would:</p>
          <ul>{table.separating.map((one) => <li key={one}>{one}</li>)}</ul>
        </>
      )}
      <p><Verdict kind={conformityKind[conformity]}>{table.verdict}</Verdict></p>
      {table.change.length > 0 && <ul>{table.change.map((one) => <li key={one}>{one}</li>)}</ul>}
    </div>
  );
}
