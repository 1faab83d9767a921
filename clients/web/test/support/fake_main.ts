// The page before the cell of make-believe: `npx vite --open /fake.html`.
import { useTransport } from '@/api/client';
import { fakeTransport } from './fake_cell';

useTransport(fakeTransport());
history.replaceState(null, '', new URLSearchParams(location.search).get('at') ?? '/now');
await import('@/main');
