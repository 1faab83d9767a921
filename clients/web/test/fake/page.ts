// The page before a daemon in memory, to look at while developing: `npx vite`, then /test/fake/page.html?at=/models/12
import { useTransport } from '@/api/client';
import { fakeDaemon } from './daemon';

useTransport(fakeDaemon());
const wanted = new URLSearchParams(location.search).get('at');
if (wanted) history.replaceState(null, '', wanted);
await import('@/main');
