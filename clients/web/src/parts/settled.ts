// [checks] stabiliser_band_k, unless the cell file says otherwise: within it a stabiliser is settled.
export const settledK = 0.01;
