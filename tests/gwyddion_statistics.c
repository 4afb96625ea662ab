/* What Gwyddion's library says about a raw height field: an independent reference for `microbrdf info`, and
   for the project's claim of speed. Built and run by gwyddion_statistics.py:

     gwyddion_statistics statistics FILE ROWS COLS DX DY   heights levelled by the masked least-squares plane,
   then one JSON object gwyddion_statistics time FILE ROWS COLS DX DY         seconds of
   gwy_data_field_fit_local_planes, size 32

   FILE holds ROWS × COLS doubles, µm, NaN = missing; DX and DY are µm. Lengths are passed on as they are. */
#include <glib-object.h>
#include <libprocess/gwyprocess.h>
#include <libprocess/gwyprocesstypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Reads the heights; missing ones become 0 in the field and 0 in the mask (1 where there is a height). */
static GwyDataField* read_field(const char* path, int rows, int cols, double dx, double dy,
                                GwyDataField** mask) {
  GwyDataField* field = gwy_data_field_new(cols, rows, cols * dx, rows * dy, TRUE);
  *mask = gwy_data_field_new_alike(field, TRUE);
  double* z = gwy_data_field_get_data(field);
  double* there = gwy_data_field_get_data(*mask);
  const size_t n = (size_t)rows * (size_t)cols;
  FILE* file = fopen(path, "rb");
  if (!file || fread(z, sizeof(double), n, file) != n) {
    fprintf(stderr, "%s: too short or unreadable\n", path);
    exit(1);
  }
  fclose(file);
  for (size_t k = 0; k < n; ++k) {
    there[k] = isnan(z[k]) ? 0 : 1;
    if (isnan(z[k])) z[k] = 0;
  }
  return field;
}

static void statistics(GwyDataField* field, GwyDataField* mask, int rows, int cols) {
  double a, bx, by, mean, sa, sq, ssk, sku, low, high;
  gwy_data_field_area_fit_plane_mask(field, mask, GWY_MASK_INCLUDE, 0, 0, cols, rows, &a, &bx, &by);
  gwy_data_field_plane_level(field, a, bx, by);
  gwy_data_field_area_get_stats_mask(field, mask, GWY_MASK_INCLUDE, 0, 0, cols, rows, &mean, &sa, &sq, &ssk,
                                     &sku);
  gwy_data_field_area_get_min_max_mask(field, mask, GWY_MASK_INCLUDE, 0, 0, cols, rows, &low, &high);
  const double slope =
      gwy_data_field_area_get_surface_slope_mask(field, mask, GWY_MASK_INCLUDE, 0, 0, cols, rows);
  const double area =
      gwy_data_field_area_get_surface_area_mask(field, mask, GWY_MASK_INCLUDE, 0, 0, cols, rows);
  double projected = 0; /* Gwyddion gives each valid point its pixel's area */
  const double* there = gwy_data_field_get_data_const(mask);
  for (int k = 0; k < rows * cols; ++k)
    projected += there[k] * gwy_data_field_get_dx(field) * gwy_data_field_get_dy(field);
  printf(
      "{\"Sq_um\": %.17g, \"Sa_um\": %.17g, \"Sz_um\": %.17g, \"Ssk\": %.17g, \"Sku\": %.17g, \"Sdq\": "
      "%.17g, "
      "\"Sdr\": %.17g}\n",
      sq, sa, high - low, ssk, sku + 3, slope, area / projected - 1);
}

static void time_local_planes(GwyDataField* field) {
  const GwyPlaneFitQuantity quantities[] = {GWY_PLANE_FIT_BX, GWY_PLANE_FIT_BY};
  struct timespec start, end;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &start);
  gwy_data_field_fit_local_planes(field, 32, 2, quantities, NULL);
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
  printf("%.4f\n", (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec));
}

int main(int argc, char** argv) {
  if (argc != 7) {
    fprintf(stderr, "usage: %s statistics|time FILE ROWS COLS DX DY\n", argv[0]);
    return 2;
  }
  gwy_process_type_init();
  const int rows = atoi(argv[3]), cols = atoi(argv[4]);
  GwyDataField* mask;
  GwyDataField* field = read_field(argv[2], rows, cols, atof(argv[5]), atof(argv[6]), &mask);
  if (strcmp(argv[1], "time") == 0)
    time_local_planes(field);
  else
    statistics(field, mask, rows, cols);
  return 0;
}
