/* Writes for -fault_output_xdmf a text file beside the output, with which ParaView opens it. FILE.part has
   FILE.part.xdmf2, which is replaced as a whole from time to time, and FILE has FILE.xdmf2: a run can be viewed while
   it continues, after it was killed, and when it has ended. The text lists the entries of /fields. Cells are
   quadrilaterals or triangles, whose corners are in /xdmf of the output.

   For this ending ParaView uses its "XDMF Reader" (vtkXdmfReader). For .xdmf it offers its Xdmf3 readers too, and uses
   them in scripts. They do not support hyperslabs, parts of a dataset, and would show cells without fields. */
#define _POSIX_C_SOURCE 200809L
#include <slipstep/private/sliprunfiles.h>
#include <errno.h>
#include <fcntl.h>
#include <petsctime.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* State of the observer; all of it is on rank 0 */
typedef struct {
  SlipFault fault;
  PetscBool wanted;
  PetscBool field[OUTPUT_MAX_FIELDS]; /* the output has this field */
  char target[PETSC_MAX_PATH_LEN];    /* the output's final name */
  PetscInt n, size;                   /* entries of /fields, and room for them */
  PetscReal *time;                    /* their times [s] */
  PetscInt written;                   /* entries in the file */
  int failed;                         /* errno of the last attempt to write it, or 0 */
  PetscLogDouble last, cost;          /* time of the last attempt, and how long it took [s] */
} Xdmf;

#define XDMF_SHARE 100 /* the pause before the file is written again, over the time of the last write */

static PetscErrorCode XdmfCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  Xdmf *x;

  PetscFunctionBegin;
  (void)ts;
  *wanted = fault->run->file && fault->options.output_xdmf ? PETSC_TRUE : PETSC_FALSE;
  if (!*wanted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&x));
  x->fault = fault;
  *ctx = x;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All functions below run on rank 0 but those of the observer. */
static PetscErrorCode LayOut(Xdmf *x, SlipOutput output, SlipH5 *h)
{
  char name[PETSC_MAX_PATH_LEN + 16], *slash;
  PetscBool has;

  PetscFunctionBegin;
  for (PetscInt f = 0; f < SlipFaultOutputCount(x->fault); f++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "/fields/%s", SlipFaultOutputField(x->fault, f)));
    PetscCall(SlipH5Has(h, name, &x->field[f]));
    x->wanted = x->wanted || x->field[f];
  }
  if (!x->wanted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(x->target, h->target, sizeof(x->target)));
  slash = strrchr(x->target, '/');
  if (strchr(slash ? slash : x->target, ':')) { /* a colon ends a file's name in XDMF */
    PetscCall(SlipWarning("no %s.xdmf2 is written, as its form has no name with a colon", x->target));
    x->wanted = PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipH5Has(h, "/xdmf/cells", &has));
  if (
    !has) { /* corners [npoints][3], z upward, and their numbers for each cell [N][sides], in the order of the output */
    const SlipFaultMesh *mesh = &x->fault->mesh;
    const PetscInt points[2] = {mesh->npoints, 3}, cells[2] = {mesh->N, mesh->kind->sides};
    PetscInt *corners;
    PetscReal *place;
    static const char *const axes[] = {"cell", "vertex"};

    PetscCall(PetscMalloc2(3 * mesh->npoints, &place, mesh->kind->sides * mesh->N, &corners));
    PetscCall(mesh->kind->corners(mesh, place, corners));
    for (PetscInt p = 0; p < mesh->npoints; p++) place[3 * p + 2] *= -1;
    PetscCall(SlipH5WriteReal(h, "/xdmf/points", 2, points, place, "m"));
    PetscCall(SlipH5WriteInt(h, "/xdmf/cells", 2, cells, corners, NULL));
    PetscCall(PetscFree2(place, corners));
    PetscCall(SlipH5MakeDimension(h, "/xdmf/cell", mesh->N));
    PetscCall(SlipH5MakeDimension(h, "/xdmf/vertex", mesh->npoints));
    PetscCall(SlipH5NameDimensions(h, "/xdmf", &(SlipH5Axes){.n = 2, .axis = axes, .rest = "corner"}));
  }
  if (output->resumed) {
    PetscCall(SlipH5ReadReal(h, "/fields/time", 1, &x->n, &x->time));
    x->size = x->n;
  }
  (void)snprintf(name, sizeof(name), "%s.part.xdmf2", x->target);
  unlink(name); /* it has outdated entries of an earlier run */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the newest entry of /fields, unless it is in the list. */
static PetscErrorCode Add(Xdmf *x)
{
  const SlipFaultRun *run = x->fault->run;

  PetscFunctionBegin;
  if (!x->wanted || x->n == run->entries) PetscFunctionReturn(PETSC_SUCCESS);
  if (x->n == x->size) {
    x->size = 2 * x->size + 64;
    PetscCall(PetscRealloc((size_t)x->size * sizeof(*x->time), &x->time));
  }
  x->time[x->n++] = run->entry_time;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode XdmfStart(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  PetscFunctionBegin;
  (void)fault;
  (void)ts;
  (void)time;
  (void)w;
  PetscCall(Add((Xdmf *)ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode XdmfStep(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  PetscFunctionBegin;
  (void)step;
  PetscCall(XdmfStart(fault, ts, time, w, ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode XdmfFinish(SlipFault fault, TS ts, SlipOutput output, void *ctx)
{
  PetscFunctionBegin;
  (void)fault;
  (void)ts;
  (void)output;
  PetscCall(Add((Xdmf *)ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the text ---- */

/* Writes the output's name for XML, without its folder. */
static void Escape(const char name[], const char ending[], char text[], size_t len)
{
  const char *c = strrchr(name, '/');
  size_t n = 0;

  for (c = c ? c + 1 : name; *c && n + 8 < len; c++) {
    const char *as = *c == '&' ? "&amp;" : *c == '<' ? "&lt;" : *c == '>' ? "&gt;" : NULL;

    n += (size_t)(as ? snprintf(text + n, len - n, "%s", as) : snprintf(text + n, len - n, "%c", *c));
  }
  (void)snprintf(text + n, len - n, "%s", ending);
}

/* Prints a field in entry k, or one of its two components, along strike and up dip; component -1: one number in
   each cell. h5: the output's name in XML */
static void PutField(const Xdmf *x, FILE *f, const char h5[], PetscInt k, PetscInt field, int component)
{
  const SlipFault fault = x->fault;
  const int bytes = !strcmp(fault->options.text[FAULT_OUTPUT_PRECISION], "single") ? 4 : 8;
  const PetscBool list = fault->mesh.ndim == 1 ? PETSC_TRUE : PETSC_FALSE;
  const char *name = SlipFaultOutputField(fault, field), *of = "", *at = "", *one = "", *two = "";
  char cells[64];

  if (list)
    (void)snprintf(cells, sizeof(cells), "%lld", (long long)fault->mesh.N);
  else
    (void)snprintf(cells, sizeof(cells), "%lld %lld", (long long)fault->mesh.dims[0], (long long)fault->mesh.dims[1]);
  if (component >= 0) {
    of = component ? "_up_dip" : "_along_strike";
    at = component ? " 1" : " 0";
    one = " 1";
    two = " 2";
  }
  fprintf(f,
          "    <Attribute Name=\"%s%s\" AttributeType=\"Scalar\" Center=\"Cell\">\n"
          "     <DataItem ItemType=\"HyperSlab\" Type=\"HyperSlab\" Dimensions=\"1 %s%s\">\n"
          "      <DataItem Dimensions=\"3 %d\" Format=\"XML\">%lld %s%s 1 %s%s 1 %s%s</DataItem>\n"
          "      <DataItem Dimensions=\"%lld %s%s\" NumberType=\"Float\" Precision=\"%d\" "
          "Format=\"HDF\">%s:/fields/%s</DataItem>\n"
          "     </DataItem>\n    </Attribute>\n",
          name, of, cells, one, (list ? 2 : 3) + (component >= 0), (long long)k, list ? "0" : "0 0", at,
          list ? "1" : "1 1", one, cells, one, (long long)x->n, cells, two, bytes, h5, name);
}

/* Prints one entry; h5: the output's name in XML */
static void PutEntry(const Xdmf *x, FILE *f, const char h5[], PetscInt k)
{
  const SlipFault fault = x->fault;
  const long long N = (long long)fault->mesh.N;
  const int sides = (int)fault->mesh.kind->sides;

  fprintf(f, "   <Grid Name=\"fault\" GridType=\"Uniform\">\n    <Time Value=\"%.17g\"/>\n", (double)x->time[k]);
  fprintf(f,
          "    <Topology TopologyType=\"%s\" NumberOfElements=\"%lld\">\n"
          "     <DataItem Dimensions=\"%lld %d\" NumberType=\"Int\" Precision=\"8\" "
          "Format=\"HDF\">%s:/xdmf/cells</DataItem>\n"
          "    </Topology>\n",
          sides == 3 ? "Triangle" : "Quadrilateral", N, N, sides, h5);
  fprintf(f,
          "    <Geometry GeometryType=\"XYZ\">\n"
          "     <DataItem Dimensions=\"%lld 3\" NumberType=\"Float\" Precision=\"8\" "
          "Format=\"HDF\">%s:/xdmf/points</DataItem>\n"
          "    </Geometry>\n",
          (long long)fault->mesh.npoints, h5);
  for (PetscInt i = 0; i < SlipFaultOutputCount(fault); i++) {
    const PetscBool vector = SlipFaultOutputComponents(fault, i) == 2 ? PETSC_TRUE : PETSC_FALSE;

    for (int c = 0; c < (vector ? 2 : 1) && x->field[i]; c++) PutField(x, f, h5, k, i, vector ? c : -1);
  }
  fprintf(f, "   </Grid>\n");
}

/* Composes the text in memory; returns NULL when there is not enough. */
static char *Text(const Xdmf *x, const char ending[], size_t *len)
{
  char h5[PETSC_MAX_PATH_LEN], *text = NULL;
  FILE *f = open_memstream(&text, len);

  if (!f) return NULL;
  Escape(x->target, ending, h5, sizeof(h5));
  fprintf(f, "<?xml version=\"1.0\"?>\n<Xdmf Version=\"2.0\">\n <Domain>\n"
             "  <Grid Name=\"fault\" GridType=\"Collection\" CollectionType=\"Temporal\">\n");
  for (PetscInt k = 0; k < x->n; k++) PutEntry(x, f, h5, k);
  fprintf(f, "  </Grid>\n </Domain>\n</Xdmf>\n");
  if (fclose(f)) {
    free(text);
    text = NULL;
  }
  return text;
}

/* Writes a file beside, and renames it to its place; returns 0, or errno. */
static int Replace(const char name[], const char text[], size_t len)
{
  char beside[PETSC_MAX_PATH_LEN + 32];
  struct rlimit limit;
  int fd, reason = 0;

  /* beyond this limit a signal ends the process by default */
  if (!getrlimit(RLIMIT_FSIZE, &limit) && limit.rlim_cur != RLIM_INFINITY && len > limit.rlim_cur) return EFBIG;
  (void)snprintf(beside, sizeof(beside), "%s.new", name);
  fd = open(beside, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (fd < 0) return errno;
  for (size_t done = 0; done < len && !reason;) {
    const ssize_t n = write(fd, text + done, len - done);

    if (n < 0 && errno != EINTR) reason = errno;
    if (n > 0) done += (size_t)n;
  }
  if (close(fd) && !reason) reason = errno;
  if (!reason && rename(beside, name)) reason = errno;
  if (reason) unlink(beside);
  return reason;
}

/* Writes the text; ending: "" or ".part" */
static PetscErrorCode Write(Xdmf *x, const char ending[])
{
  char name[PETSC_MAX_PATH_LEN + 16], *text;
  PetscLogDouble begin;
  size_t len = 0;

  PetscFunctionBegin;
  PetscCall(PetscTime(&begin));
  (void)snprintf(name, sizeof(name), "%s%s.xdmf2", x->target, ending);
  text = Text(x, ending, &len);
  x->failed = text ? Replace(name, text, len) : ENOMEM;
  free(text);
  x->written = x->n;
  PetscCall(PetscTime(&x->last));
  x->cost = x->last - begin;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the text when the output is on the disk with all its entries. After a failure it tries again later. */
static PetscErrorCode Flushed(Xdmf *x, PetscBool last)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  if (!x->wanted || (x->n == x->written && !x->failed)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscTime(&now));
  if (last || now - x->last >= XDMF_SHARE * x->cost) PetscCall(Write(x, ".part"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode XdmfFlushed(SlipOutput output, void *ctx)
{
  PetscFunctionBegin;
  (void)output;
  PetscCall(Flushed((Xdmf *)ctx, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode XdmfLayout(SlipFault fault, SlipOutput output, void *ctx)
{
  SlipH5 *h = SlipOutputFile(output);
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (h) ierr = LayOut((Xdmf *)ctx, output, h);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  output->flushed = XdmfFlushed;
  output->flushed_ctx = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the text for the final name of the output, or for its unfinished file. */
static PetscErrorCode XdmfDestroy(void **ctx)
{
  Xdmf *x = (Xdmf *)*ctx;
  char part[PETSC_MAX_PATH_LEN + 16];

  PetscFunctionBegin;
  if (x->wanted && x->fault->run->complete) {
    PetscCall(Write(x, ""));
    (void)snprintf(part, sizeof(part), "%s.part.xdmf2", x->target);
    unlink(part);
    if (x->failed) PetscCall(SlipWarning("cannot write %s.xdmf2: %s", x->target, strerror(x->failed)));
  } else
    PetscCall(Flushed(x, PETSC_TRUE));
  PetscCall(PetscFree(x->time));
  PetscCall(PetscFree(*ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultObserver SlipFaultXdmfObserver = {.name = "xdmf",
                                                 .create = XdmfCreate,
                                                 .layout = XdmfLayout,
                                                 .start = XdmfStart,
                                                 .step = XdmfStep,
                                                 .finish = XdmfFinish,
                                                 .destroy = XdmfDestroy};
