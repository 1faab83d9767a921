// The client of commissioning: fetched with its views, not with the page.
import { lazily } from '@/api/client';
import { CommissioningService } from '@/api/gen/driftwise/v1/commissioning_service_pb';

export const commissioningApi = lazily(CommissioningService);
