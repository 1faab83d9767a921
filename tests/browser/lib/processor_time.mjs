// Processor time of processes, from /proc: what other work on the machine takes does not count.
import { readdirSync, readFileSync } from 'node:fs';

const all = () => readdirSync('/proc').filter((name) => /^\d+$/.test(name));

// Seconds of a process and all its descendants.
export function processorSeconds(roots) {
  const stats = all().flatMap((pid) => {
    try {
      const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').replace(/^.*\) /, '').split(' ');
      return [{ pid: Number(pid), parent: Number(fields[1]), s: (Number(fields[11]) + Number(fields[12])) / 100 }];
    } catch {
      return [];
    }
  });
  const wanted = new Set(roots);
  for (let grew = true; grew; ) {
    grew = false;
    for (const one of stats) if (wanted.has(one.parent) && !wanted.has(one.pid)) grew = !!wanted.add(one.pid);
  }
  return stats.filter((one) => wanted.has(one.pid)).reduce((sum, one) => sum + one.s, 0);
}

// The processes of a browser, by the folder of its profile.
export const browserPids = (profile) => all().filter((pid) => {
  try {
    return readFileSync(`/proc/${pid}/cmdline`, 'utf8').includes(profile);
  } catch {
    return false;
  }
}).map(Number);

// Percent of a core that the processes take for some seconds.
export async function percentOfACore(pids, seconds) {
  const [before, began] = [processorSeconds(pids()), performance.now()];
  await new Promise((done) => setTimeout(done, seconds * 1000));
  return (100 * (processorSeconds(pids()) - before)) / ((performance.now() - began) / 1000);
}
