// What the keys do, who sits here, how the page looks.
import { Button } from '@/ui/button';
import { Dialog } from '@/ui/dialog';
import type { DatabaseStatus } from '@/api/gen/driftwise/v1/cell_service_pb';
import { dateClock, ms } from '@/format/time';
import { cell } from '@/live/state';
import { AlarmSwitches } from '@/parts/alarm_switches';
import { helpOpen, keysOn, setKeysOn } from './keys';
import { askName } from './name';
import { operatorName, session } from './session';
import { setTheme, theme, type Theme } from './theme';
import { views } from './views';

const others: readonly [string, string][] = [
  ['/', 'search field'],
  ['j k', 'next, previous row; Enter opens it'],
  ['+ − 0 ← →', 'zoom, everything, pan, in a plot'],
  ['?', 'this page'],
];

export function HelpDialog() {
  return (
    <Dialog subject={helpOpen.value} titleId="help-title" onEnd={() => (helpOpen.value = false)}>
      <HelpContent />
    </Dialog>
  );
}

// When the pages of the database were last found whole. Trouble with them is an alarm.
function databaseWords(database: DatabaseStatus | undefined): string {
  if (!database) return '';
  if (database.troubles.length > 0) return 'The database is damaged: see the alarms';
  const under = database.checkedTableCount < database.tableCount ? `, a check is under way (${database.checkedTableCount} of ${database.tableCount} tables)` : '';
  return (database.cleanTime ? `The database was found clean on ${dateClock(ms(database.cleanTime))}` : 'The database has not been checked whole yet') + under;
}

function HelpContent() {
  return (
    <>
      <h2 id="help-title">Settings and keys</h2>
      <div class="stack">
        <div class="row">
          <span>You are <strong>{operatorName.value || 'not named yet'}</strong>{session.value.state === 'in' && `, ${session.value.role}`}</span>
          <Button small onPress={() => void askName()}>{session.value.state === 'in' ? 'Session' : operatorName.value ? 'Change the name' : 'Type your name'}</Button>
        </div>
        <fieldset class="choices">
          <legend>Colours</legend>
          {(['system', 'light', 'dark'] as Theme[]).map((one) => (
            <label key={one}>
              <input type="radio" name="theme" checked={theme.value === one} onChange={() => setTheme(one)} />
              {one === 'system' ? 'as the system' : one}
            </label>
          ))}
        </fieldset>
        <label class="choice">
          <input type="checkbox" checked={keysOn.value} onChange={(event) => setKeysOn(event.currentTarget.checked)} />
          Single keys act as below
        </label>
        <AlarmSwitches />
        <dl class="facts keys">
          {views.map((view) => [<dt><kbd>g</kbd> <kbd>{view.key}</kbd></dt>, <dd>{view.title}</dd>])}
          {others.map(([keys, what]) => [<dt>{keys.split(' ').map((key) => <kbd>{key}</kbd>)}</dt>, <dd>{what}</dd>])}
        </dl>
        <p class="note muted">Driftwise {cell.value?.version}, cell {cell.value?.cellName}, configuration {cell.value?.configHash.slice(0, 12)}</p>
        <p class="note muted">{databaseWords(cell.value?.database)}</p>
      </div>
      <div class="actions"><Button onPress={() => (helpOpen.value = false)}>Close</Button></div>
    </>
  );
}
