/* Receiver of a multicast group.  A thread empties the socket into a bounded queue: joint states
 * are not lost during disk waits, and a flood does not consume memory. */
#include "lcm/packet.h"

#include <arpa/inet.h>
#include <errno.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "base/clock.h"

enum { DATAGRAM = 65536 /* bytes: exceeds UDP's maximum */, MAX_LOCAL = 64 };

struct mukca_lcm_multicast {
    mukca_lcm_multicast_options options;
    int socket;
    int stop, ready; /* eventfd: termination of the thread; readable while a message waits */
    bool running;
    pthread_t thread;
    /* private to the thread */
    mukca_lcm_reassembly reassembly;
    uint32_t local[MAX_LOCAL]; /* addresses of this machine */
    int n_local;
    int64_t local_read; /* us, time of reading them */
    unsigned char datagram[DATAGRAM];
    uint32_t overflowed; /* datagrams dropped by the kernel */
    /* shared, under `lock` */
    pthread_mutex_t lock;
    mukca_lcm_queue queue;
    mukca_lcm_channels channels;
    int64_t foreign, dropped; /* of senders that are not accepted; in all */
    char reason[128];         /* of the last one */
};

/* ---- accepted senders ---- */

static void read_local(mukca_lcm_multicast *m, int64_t now)
{
    struct ifreq list[MAX_LOCAL];
    memset(list, 0, sizeof list);
    struct ifconf request = {.ifc_len = sizeof list, .ifc_req = list};
    m->local_read = now;
    if (ioctl(m->socket, SIOCGIFCONF, &request)) return;
    m->n_local = request.ifc_len / (int)sizeof list[0];
    for (int i = 0; i < m->n_local; i++) {
        struct sockaddr_in address;
        memcpy(&address, &list[i].ifr_addr, sizeof address);
        m->local[i] = ntohl(address.sin_addr.s_addr);
    }
}

static bool contains(const uint32_t *list, int n, uint32_t address)
{
    for (int i = 0; i < n; i++)
        if (list[i] == address) return true;
    return false;
}

/* Whether a sender is accepted.  The kernel drops datagrams from outside with an address of this
 * machine. */
static bool may_send(mukca_lcm_multicast *m, uint32_t address, int64_t now)
{
    const mukca_lcm_multicast_options *o = &m->options;
    if (o->n_from) return contains(o->from, o->n_from, address);
    if (o->interface) return true;
    /* 0: a sender whose interface has no address; from outside, the kernel drops it */
    if (!address || address >> 24 == IN_LOOPBACKNET || contains(m->local, m->n_local, address))
        return true;
    /* addresses of the machine may have changed */
    if (now - m->local_read < 1000000 && now >= m->local_read) return false;
    read_local(m, now);
    return contains(m->local, m->n_local, address);
}

/* ---- the thread ---- */

static bool is_wanted(const mukca_lcm_channels *channels, const char *channel)
{
    bool wanted = channels->all;
    for (int i = 0; i < MUKCA_LCM_MAX_NAMED; i++)
        wanted = wanted || strcmp(channels->name[i], channel) == 0;
    return wanted;
}

static void process(mukca_lcm_multicast *m, size_t size, const struct sockaddr_in *from,
                    int64_t now)
{
    uint32_t address = ntohl(from->sin_addr.s_addr);
    mukca_lcm_packet packet = {.data = m->datagram,
                               .size = size,
                               .time = now,
                               .sender = (uint64_t)address << 16 | ntohs(from->sin_port)};
    const int64_t malformed = m->reassembly.dropped;
    bool known = may_send(m, address, now);
    bool whole = known && mukca_lcm_packet_take(&packet, &m->reassembly);
    pthread_mutex_lock(&m->lock);
    if (whole && is_wanted(&m->channels, packet.channel) &&
        mukca_lcm_queue_push(&m->queue, &packet))
        (void)eventfd_write(m->ready, 1);
    m->foreign += !known;
    const int64_t dropped =
        m->foreign + m->reassembly.dropped + m->queue.dropped + (int64_t)m->overflowed;
    if (!known)
        snprintf(m->reason, sizeof m->reason,
                 "sent by %u.%u.%u.%u; --interface and --from accept others", address >> 24,
                 address >> 16 & 255, address >> 8 & 255, address & 255);
    else if (dropped != m->dropped)
        snprintf(m->reason, sizeof m->reason, "%s",
                 m->reassembly.dropped != malformed
                     ? m->reassembly.reason
                     : "more than can be handled, or this program was stopped");
    m->dropped = dropped;
    pthread_mutex_unlock(&m->lock);
}

/* Receive a datagram; *time is when the kernel received it: a process that was stopped or starved
 * reads old ones.  Returns its size, -1: none. */
static ssize_t receive(mukca_lcm_multicast *m, struct sockaddr_in *from, int64_t *time)
{
    union {
        struct cmsghdr head; /* for the alignment */
        char bytes[CMSG_SPACE(sizeof(struct timeval)) + CMSG_SPACE(sizeof(uint32_t))];
    } control;
    struct iovec data = {.iov_base = m->datagram, .iov_len = sizeof m->datagram};
    struct msghdr message = {.msg_name = from,
                             .msg_namelen = sizeof *from,
                             .msg_iov = &data,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    const ssize_t n = recvmsg(m->socket, &message, MSG_DONTWAIT);
    *time = mukca_clock_wall();
    if (n < 0) return n;
    for (struct cmsghdr *c = CMSG_FIRSTHDR(&message); c; c = CMSG_NXTHDR(&message, c)) {
        struct timeval t;
        if (c->cmsg_level != SOL_SOCKET) continue;
        if (c->cmsg_type == SCM_TIMESTAMP) {
            memcpy(&t, CMSG_DATA(c), sizeof t);
            *time = (int64_t)t.tv_sec * 1000000 + t.tv_usec;
        } else if (c->cmsg_type == SO_RXQ_OVFL) {
            memcpy(&m->overflowed, CMSG_DATA(c), sizeof m->overflowed);
        }
    }
    return n;
}

static void *run(void *multicast)
{
    mukca_lcm_multicast *m = multicast;
    struct pollfd p[2] = {{.fd = m->socket, .events = POLLIN}, {.fd = m->stop, .events = POLLIN}};
    for (;;) {
        if (poll(p, 2, -1) < 0 && errno != EINTR) break;
        if (p[1].revents) break;
        for (int i = 0; i < 256; i++) { /* before polling `stop` again */
            struct sockaddr_in from = {.sin_family = AF_INET};
            int64_t time;
            const ssize_t n = receive(m, &from, &time);
            if (n < 0) break;
            process(m, (size_t)n, &from, time);
        }
    }
    return NULL;
}

/* ---- open and close ---- */

static bool join(const mukca_lcm_multicast *m, uint32_t interface)
{
    struct ip_mreq group = {.imr_multiaddr.s_addr = htonl(m->options.group),
                            .imr_interface.s_addr = htonl(interface)};
    return setsockopt(m->socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) == 0;
}

/* Open the socket.  Bound to the group's address, it receives no unicast. */
static bool open_socket(mukca_lcm_multicast *m)
{
    const mukca_lcm_multicast_options *o = &m->options;
    int on = 1, off = 0;
    struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons(o->port), .sin_addr.s_addr = htonl(o->group)};
    m->socket = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (m->socket < 0) return false;
    if (setsockopt(m->socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on)) return false;
    (void)setsockopt(m->socket, SOL_SOCKET, SO_RCVBUF, &o->buffer, sizeof o->buffer);
    (void)setsockopt(m->socket, SOL_SOCKET, SO_TIMESTAMP, &on, sizeof on);
    (void)setsockopt(m->socket, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
#ifdef IP_MULTICAST_ALL /* receive from this socket's interfaces only, not from those that other \
                           programs joined */
    if (setsockopt(m->socket, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off)) return false;
#endif
    if (bind(m->socket, (const struct sockaddr *)&address, sizeof address)) return false;
    if (o->interface) return join(m, o->interface);
    bool routed = join(m, INADDR_ANY);
    int reason = errno;
    bool loop = join(m, INADDR_LOOPBACK);
    if (routed || loop) return true;
    errno = reason;
    return false;
}

/* Start the thread with all signals blocked; the main thread handles them. */
static bool start_thread(mukca_lcm_multicast *m)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    errno = pthread_create(&m->thread, NULL, run, m);
    m->running = errno == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return m->running;
}

mukca_status mukca_lcm_multicast_open(mukca_lcm_multicast **out,
                                      const mukca_lcm_multicast_options *options,
                                      mukca_error *error)
{
    mukca_lcm_multicast *m = calloc(1, sizeof *m);
    *out = NULL;
    if (!m) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    m->options = *options;
    m->socket = -1;
    m->stop = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    m->ready = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    pthread_mutex_init(&m->lock, NULL);
    if (m->stop < 0 || m->ready < 0 || !open_socket(m) || !start_thread(m)) {
        mukca_fail(error, MUKCA_TRANSPORT,
                   "LCM cannot join %u.%u.%u.%u port %u: %s (multicast route? --interface?)",
                   options->group >> 24, options->group >> 16 & 255, options->group >> 8 & 255,
                   options->group & 255, options->port, strerror(errno));
        mukca_lcm_multicast_close(m);
        return MUKCA_TRANSPORT;
    }
    *out = m;
    return MUKCA_OK;
}

void mukca_lcm_multicast_close(mukca_lcm_multicast *m)
{
    if (!m) return;
    if (m->running && eventfd_write(m->stop, 1) == 0) pthread_join(m->thread, NULL);
    const int descriptors[] = {m->socket, m->stop, m->ready};
    for (size_t i = 0; i < sizeof descriptors / sizeof descriptors[0]; i++)
        if (descriptors[i] >= 0) close(descriptors[i]);
    mukca_lcm_packet_clear(&m->reassembly);
    pthread_mutex_destroy(&m->lock);
    for (mukca_lcm_queued *e; (e = mukca_lcm_queue_take(&m->queue));) free(e);
    free(m);
}

/* ---- for the program ---- */

void mukca_lcm_multicast_listen(mukca_lcm_multicast *m, const mukca_lcm_channels *channels)
{
    if (!m) return;
    pthread_mutex_lock(&m->lock);
    m->channels = *channels;
    pthread_mutex_unlock(&m->lock);
}

int mukca_lcm_multicast_descriptor(const mukca_lcm_multicast *m)
{
    return m->ready;
}

mukca_lcm_queued *mukca_lcm_multicast_take(mukca_lcm_multicast *m)
{
    eventfd_t count;
    pthread_mutex_lock(&m->lock);
    mukca_lcm_queued *oldest = mukca_lcm_queue_take(&m->queue);
    if (!m->queue.first) (void)eventfd_read(m->ready, &count);
    pthread_mutex_unlock(&m->lock);
    return oldest;
}

int64_t mukca_lcm_multicast_dropped(mukca_lcm_multicast *m, char reason[128])
{
    if (!m) return 0;
    pthread_mutex_lock(&m->lock);
    const int64_t dropped = m->dropped;
    memcpy(reason, m->reason, sizeof m->reason);
    pthread_mutex_unlock(&m->lock);
    return dropped;
}
