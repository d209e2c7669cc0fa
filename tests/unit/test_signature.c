/* Signatures of LCM requests against those of OpenSSL and against what they must not accept. */
#include "lcm/message.h"
#include "scratch.h"

static mukca_status read_key(mukca_lcm_key *key, const char *text, size_t n)
{
    const char *path = scratch_bytes("key", text, n);
    assert_int_equal(chmod(path, 0600), 0);
    return mukca_lcm_key_read(key, path, &error);
}

/* printf 'A\0Test' | openssl dgst -sha256 -mac HMAC -macopt hexkey:aaaa...: a key longer than a
 * block and a shorter one, as in RFC 4231. */
TEST(it_is_hmac_sha256)
{
    static const unsigned char expected[2][8] = {{0x20, 0xfe, 0xed, 0x64, 0x17, 0x1d, 0x35, 0x22},
                                                 {0xe4, 0x1f, 0x02, 0x49, 0xbc, 0xfd, 0xbd, 0x3a}};
    char text[131];
    memset(text, 0xaa, sizeof text);
    const size_t sizes[2] = {131, 20};
    for (int i = 0; i < 2; i++) {
        mukca_lcm_key key;
        unsigned char signature[MUKCA_LCM_SIGNATURE];
        assert_ok(read_key(&key, text, sizes[i]));
        const mukca_lcm_packet packet = {.channel = "A", .data = "Test", .size = 4};
        mukca_lcm_signature_make(signature, &key, &packet);
        assert_memory_equal(signature, expected[i], 8);
    }
}

TEST(another_byte_channel_or_key_is_refused)
{
    mukca_lcm_key key, other;
    unsigned char data[40 + MUKCA_LCM_SIGNATURE] = "forty bytes of a message";
    assert_ok(read_key(&key, "0123456789abcdef\n", 17));
    assert_ok(read_key(&other, "0123456789abcdeg", 16));
    mukca_lcm_packet packet = {.channel = "MUKCA_COMMAND", .data = data, .size = 40};
    mukca_lcm_signature_make(data + 40, &key, &packet);
    packet.size = sizeof data;
    assert_true(mukca_lcm_signature_check(&key, &packet));
    assert_false(mukca_lcm_signature_check(&other, &packet));
    packet.channel = "MUKCA_TRIGGER";
    assert_false(mukca_lcm_signature_check(&key, &packet));
    packet.channel = "MUKCA_COMMAND";
    for (size_t i = 0; i < sizeof data; i++) {
        data[i] ^= 1;
        assert_false(mukca_lcm_signature_check(&key, &packet));
        data[i] ^= 1;
    }
    for (packet.size = 0; packet.size < sizeof data; packet.size++)
        assert_false(mukca_lcm_signature_check(&key, &packet));
}

TEST(a_signed_request_is_read_without_a_key)
{
    unsigned char data[200];
    mukca_message_trigger trigger = {.utime = 1, .id = 2, .placement = "p", .socket = "0"};
    mukca_message_sample sample = {.id = 3};
    size_t n = mukca_message_encode(data, sizeof data, MUKCA_MESSAGE_TRIGGER, &trigger);
    memset(data + n, 7, MUKCA_LCM_SIGNATURE);
    for (size_t more = 0; more <= MUKCA_LCM_SIGNATURE + 1; more++)
        assert_int_equal(
            mukca_message_decode(&trigger, MUKCA_MESSAGE_TRIGGER, data, n + more, &error),
            more == 0 || more == MUKCA_LCM_SIGNATURE ? MUKCA_OK : MUKCA_INPUT);
    n = mukca_message_encode(data, sizeof data, MUKCA_MESSAGE_SAMPLE, &sample);
    assert_int_equal(
        mukca_message_decode(&sample, MUKCA_MESSAGE_SAMPLE, data, n + MUKCA_LCM_SIGNATURE, &error),
        MUKCA_INPUT);
}

TEST(bad_keys_get_one_clear_line)
{
    mukca_lcm_key key;
    assert_refused(read_key(&key, "fifteen letters \n", 17), "at least 16");
    assert_refused(read_key(&key, "sixteen\0 letters", 16), "zero byte");
    const char *path = scratch_file("open", "0123456789abcdef");
    assert_int_equal(chmod(path, 0644), 0);
    assert_refused(mukca_lcm_key_read(&key, path, &error), "any user can read");
    assert_refused(mukca_lcm_key_read(&key, "/nowhere/key", &error), "/nowhere/key");
}

TEST_MAIN(scratch_setup, scratch_teardown)
