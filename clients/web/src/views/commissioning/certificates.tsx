// Certificates of the instruments by the cell file.
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { Verdict } from '@/ui/verdict';
import { commissioningApi } from './api';

export function Certificates() {
  const asked = useAsked('certificates', async (signal) => commissioningApi().listCertificates({}, { signal }));
  const found = asked.value;
  return (
    <Panel title="Certificates">
      {asked.failure && <Failed asked="List the certificates" failure={asked.failure} again={asked.again} />}
      {!found && !asked.failure && <Awaiting what="the certificates" />}
      {found && found.certificates.length === 0 && <Empty next="[[certificate]] in the cell file states number, laboratory, date and due date.">No certificate is declared.</Empty>}
      {found && found.certificates.length > 0 && (
        <Table
          caption="Certificates of the instruments"
          rows={found.certificates}
          keyOf={(one) => `${one.deviceId} ${one.number}`}
          columns={[
            { title: 'device', of: (one) => one.deviceId },
            { title: 'number', of: (one) => one.number },
            { title: 'laboratory', of: (one) => one.laboratory },
            { title: 'date', of: (one) => one.date },
            { title: 'due', of: (one) => one.dueDate || 'none stated' },
            { title: 'state', of: (one) => (one.daysLeft === undefined ? '–' : one.daysLeft < 0n ? <Verdict kind="warn">{String(-one.daysLeft)} days overdue</Verdict> : <Verdict kind="good">{String(one.daysLeft)} days left</Verdict>) },
          ]}
        />
      )}
      {found && found.without.length > 0 && <p class="muted">None declared for {found.without.join(', ')}.</p>}
    </Panel>
  );
}
