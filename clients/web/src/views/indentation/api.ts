// The client of indentations: fetched with its view, not with the page.
import { lazily } from '@/api/client';
import { IndentationService } from '@/api/gen/driftwise/v1/indentation_service_pb';

export const indentationApi = lazily(IndentationService);
