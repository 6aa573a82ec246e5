/*
  Runs a test within a time, and leaves none of its processes:

    bounded SECONDS COMMAND [ARGUMENT...]

  Whatever a test starts belongs to this process, also ranks of mpirun, which have groups of their own, and what goes on
  after its parent has ended. All of it ends with the test, at the limit, when this process is told to end, and when the
  one that started it (ctest) is killed. The exit code is the command's; 124: it was stopped; 1: it left processes that
  do not end by themselves.
*/
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#if defined(__linux__)
  #include <sys/prctl.h>
#endif

#define GRACE 10 /* to end by themselves, or after SIGTERM, unless BOUNDED_GRACE says otherwise [s] */

/* Sends a signal to the children of a process, 0: none, and says which they are; their number */
static int Children(pid_t parent, int number, int say)
{
  DIR *folder = opendir("/proc");
  struct dirent *entry;
  int count = 0;

  while (folder && (entry = readdir(folder))) {
    const pid_t pid = (pid_t)atol(entry->d_name);
    char file[300], text[512], state = 'Z', *name;
    size_t n = 0;
    int of = 0;
    FILE *f;

    if (pid <= 0) continue;
    (void)snprintf(file, sizeof(file), "/proc/%ld/stat", (long)pid);
    if ((f = fopen(file, "r"))) {
      n = fread(text, 1, sizeof(text) - 1, f);
      fclose(f);
    }
    text[n] = '\0';
    name = strrchr(text, ')'); /* PID (NAME) STATE PARENT */
    if (!name || sscanf(name + 1, " %c %d", &state, &of) != 2 || of != parent || state == 'Z') continue;
    count++;
    if (say) (void)fprintf(stderr, "bounded: left running: %.*s)\n", (int)(name - text), text);
    if (number) (void)Children(pid, number, 0);
    if (number) (void)kill(pid, number);
  }
  if (folder) closedir(folder);
  return count;
}

/* Waits until there is no child for at most this time [s]; status: of the command */
static int Gone(double seconds, pid_t command, int *status)
{
  const struct timespec nap = {0, 20000000};
  pid_t pid;
  int ended;

  for (double spent = 0;; spent += 0.02) {
    while ((pid = waitpid(-1, &ended, WNOHANG)) > 0)
      if (pid == command) *status = ended;
    if (pid < 0 && errno == ECHILD) return 1;
    if (spent >= seconds) return 0;
    nanosleep(&nap, NULL);
  }
}

int main(int argc, char **argv)
{
  const char *grace = getenv("BOUNDED_GRACE");
  const pid_t starter = getppid();
  const int stops[] = {SIGTERM, SIGINT, SIGHUP, SIGCHLD};
  struct timespec left = {0, 0};
  sigset_t all, before;
  pid_t command;
  time_t end;
  int status = 0, number = SIGCHLD, over = 0;

  if (argc < 3 || (left.tv_sec = atol(argv[1])) <= 0) {
    (void)fprintf(stderr, "usage: bounded SECONDS COMMAND [ARGUMENT...]\n");
    return 2;
  }
  end = time(NULL) + left.tv_sec;
  sigemptyset(&all);
  for (size_t i = 0; i < sizeof(stops) / sizeof(*stops); i++) sigaddset(&all, stops[i]);
  sigprocmask(SIG_BLOCK, &all, &before);
#if defined(__linux__)
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != starter) return 124;
#endif
  if ((command = fork()) == 0) {
    sigprocmask(SIG_SETMASK, &before, NULL);
    execvp(argv[2], argv + 2);
    perror(argv[2]);
    _exit(127);
  }
  if (command < 0) {
    perror("bounded: fork");
    return 1;
  }
  while (!over && number == SIGCHLD) {
    pid_t pid;
    int ended;

    number = sigtimedwait(&all, NULL, &left);
    left.tv_sec = end > time(NULL) ? end - time(NULL) : 0;
    if (number < 0 && errno == EINTR) number = SIGCHLD;
    while ((pid = waitpid(-1, &ended, WNOHANG)) > 0)
      if (pid == command) {
        status = ended;
        over = 1;
      }
  }
  if (!over) {
    (void)fprintf(stderr, "bounded: %s after %s s\n", number < 0 ? "stopped" : strsignal(number), argv[1]);
    (void)Children(getpid(), SIGTERM, 0);
  }
  if (!Gone(grace ? atof(grace) : GRACE, command, &status)) {
    (void)Children(getpid(), 0, 1);
    do {
      (void)Children(getpid(), SIGKILL, 0);
      if (!over) (void)kill(command, SIGKILL);
    } while (!Gone(0.1, command, &status));
    if (over && !status) return 1;
  }
  if (!over) return 124;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}
