// The client of looking back: fetched with its view, not with the page.
import { lazily } from '@/api/client';
import { LookBackService } from '@/api/gen/driftwise/v1/look_back_service_pb';

export const lookBackApi = lazily(LookBackService);
