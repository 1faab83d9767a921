// Sound and browser notification of a new alarm, on every view once somebody has switched them on. A browser plays sound only after a click on the page, so that sound is off again after a reload.
import { effect, signal } from '@preact/signals';
import { Alarm_Priority, type Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { alarmKey, arrived, levelWords } from './alarms';

export const sound = signal(false);
export const notices = signal(false);
export const noticesRefused = signal<string | undefined>(undefined);

let context: AudioContext | undefined;

// Two tones; the higher the priority the more often.
function play(alarm: Alarm): void {
  if (!context) return;
  const times = Math.max(1, alarm.priority - Alarm_Priority.LOW);
  for (let i = 0; i < times; i++)
    for (const [hz, at] of [[880, 0], [660, 0.18]] as const) {
      const begin = context.currentTime + i * 0.5 + at;
      const tone = context.createOscillator();
      const gain = context.createGain();
      tone.frequency.value = hz;
      gain.gain.setValueAtTime(0.2, begin);
      gain.gain.linearRampToValueAtTime(0, begin + 0.16);
      tone.connect(gain).connect(context.destination);
      tone.start(begin);
      tone.stop(begin + 0.17);
    }
}

export async function switchSound(on: boolean): Promise<void> {
  if (on) {
    context ??= new AudioContext();
    await context.resume();
  }
  sound.value = on;
}

export async function switchNotices(on: boolean): Promise<void> {
  noticesRefused.value = undefined;
  if (on && typeof Notification === 'undefined') noticesRefused.value = 'This browser has no notifications on a page without TLS.';
  else if (on && (await Notification.requestPermission()) !== 'granted') noticesRefused.value = 'The browser refuses notifications of this page: allow them in its settings.';
  notices.value = on && noticesRefused.value === undefined;
}

function notify(alarm: Alarm): void {
  try {
    new Notification(`${levelWords[alarm.level]}: ${alarm.subject}`, { body: alarm.message, tag: `alarm-${alarmKey(alarm)}`, renotify: true } as NotificationOptions);
  } catch { // a browser of a phone: permission is given, and the constructor throws
    notices.value = false;
    noticesRefused.value = 'This browser shows no notifications of a page.';
  }
}

let told: readonly Alarm[] = [];
effect(() => {
  const fresh = arrived.value.filter((alarm) => !told.includes(alarm));
  told = arrived.value;
  if (fresh.length === 0) return;
  const worst = fresh.reduce((a, b) => (b.priority > a.priority ? b : a));
  if (sound.peek()) play(worst);
  for (const alarm of fresh) if (notices.peek()) notify(alarm);
});
