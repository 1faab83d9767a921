// The queue's client: fetched with its view, not with the page.
import { lazily } from '@/api/client';
import { QueueService } from '@/api/gen/driftwise/v1/queue_service_pb';

export const queueApi = lazily(QueueService);
