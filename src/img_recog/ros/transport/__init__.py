"""Faster and safer transport by means of the internals of rospy, which no other folder uses.

Checked with rospy 1.15.15 (Debian 12) and 1.16.0 (noetic-devel), whose tcpros and rosout code is
identical. test/unit/ros/transport fails for another version of rospy if a name or a signature is
different.

Names that are used
    image_publisher.py
        `impl` of a Publisher: connections, seq.
    outbox.py, outbox_publisher.py
        `impl` of a Publisher: c_lock, connections; add_connection, which is replaced. A
        connection's socket, close, stat_bytes, stat_num_msg; write_data, which is replaced, and
        `outbox`, which is added.
    image_subscriber.py
        `impl` of a Subscriber: c_lock, connections, callbacks, statistics_logger, add_callback,
        _invoke_callback; add_connection, which is replaced. A connection's endpoint_id, header,
        _connection_header (of its messages), is_latched, stat_num_msg and protocol; of
        the protocol, buff_size, and read_messages, which is replaced.
    direct_publisher.py
        `impl` of a Publisher: publock, closed, connections, is_latch, latch, seq.
    rosout.py
        rospy.impl.rosout: Publisher, which is replaced, and _rosout_pub.
        rospy.impl.paramserver: get_param_server_cache().get, which is replaced.
        rospy.impl.registration.get_topic_manager().get_topics().
    redelivery.py
        `impl` of a Publisher: connections.
    settled_subscriber.py
        `impl` of a Subscriber: c_lock, connections; add_connection, which is replaced, and
        `watch`, which is added. A connection's socket, done and read_buff; receive_once, which is
        replaced.
    own_time.py
        rospy.rostime: _set_rostime, _rostime_cond.
    registration.py
        rospy.impl.registration: get_registration_listeners().listeners,
        RegManager.publisher_update; get_topic_manager(), its get_publications() and
        get_subscriptions(); get_service_manager().get_services().

Switching it off
    With IMG_RECOG_PLAIN_ROSPY=1, all parts use only rospy's documented interface. With
    IMG_RECOG_PLAIN_ROSPY=rosout,own_time, only these parts do (the names are in switch.py).

Safety
    A node in lockstep that has ended and come back gets the message that was not answered
    (redelivery), and commands that were sent before an answer are taken before time goes on
    (settled_subscriber). A subscriber that does not read never blocks the publisher
    (direct_publisher).

Gain
    With registration.py, ros/master_watch.py can make nodes known to a new master (rospy
    registers once; doc/safety.md). The other parts save CPU time:
    the head of each says how much, as ./run bench transport measures it: with the part and without
    it in turn, 5 times, with frames of a film of 640x480, by color_extract alone or viewed, and
    with a simulator all of whose topics are subscribed. The ranges are those of the 5, on two
    cores that other programs used too. Without any part, a frame takes 2.8 times as much CPU time
    (2.3 to 2.8), viewed 2.1 times (2.0 to 2.3).
"""
