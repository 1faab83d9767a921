// Whether a new alarm is heard, and shown by the browser.
import { notices, noticesRefused, sound, switchNotices, switchSound } from '@/live/alarm_signals';
import { Button } from '@/ui/button';

export function AlarmSwitches() {
  return (
    <div class="actions">
      <Button small onPress={() => void switchSound(!sound.value)}>{sound.value ? 'Alarm sound: on' : 'Alarm sound: off'}</Button>
      <Button small onPress={() => void switchNotices(!notices.value)}>{notices.value ? 'Browser notifications: on' : 'Browser notifications: off'}</Button>
      {noticesRefused.value && <span class="wrong">{noticesRefused.value}</span>}
    </div>
  );
}
