"""Ill-behaved neighbours, which no client library can be: a publisher and a subscriber that speak TCPROS by hand."""
import socket
import struct
import threading
import xmlrpc.client
from xmlrpc.server import SimpleXMLRPCServer

import rosgraph


def header(**fields):
    """A connection header: a length, and "name=value" with a length each."""
    lines = [("%s=%s" % field).encode() for field in fields.items()]
    text = b"".join(struct.pack("<I", len(line)) + line for line in lines)
    return struct.pack("<I", len(text)) + text


def read_header(connection):
    length, = struct.unpack("<I", connection.recv(4, socket.MSG_WAITALL))
    return connection.recv(length, socket.MSG_WAITALL)


class RawPublisher:
    """Registered like any publisher. Sends each subscriber that connects the bytes of `payload`, and hangs up."""

    def __init__(self, name, topic, kind, payload):
        self.name, self.topic, self.kind, self.payload = name, topic, kind, payload
        self.master = rosgraph.Master(name)
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.api = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False, allow_none=True)
        self.api.register_function(self.request_topic, "requestTopic")
        self.uri = "http://127.0.0.1:%d/" % self.api.server_address[1]
        self.served = 0
        for work in (self.api.serve_forever, self.serve):
            threading.Thread(target=work, daemon=True).start()
        self.call("registerPublisher", topic, kind._type, self.uri)

    def call(self, method, *arguments):
        getattr(xmlrpc.client.ServerProxy(self.master.master_uri), method)(self.name, *arguments)

    def request_topic(self, caller, topic, protocols):
        return [1, "", ["TCPROS", "127.0.0.1", self.listener.getsockname()[1]]]

    def serve(self):
        while True:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                return  # closed
            with connection:
                read_header(connection)
                connection.sendall(header(callerid=self.name, topic=self.topic, type=self.kind._type, md5sum=self.kind._md5sum,
                                          latching="0", message_definition="") + self.payload)
            self.served += 1

    def close(self):
        self.call("unregisterPublisher", self.topic, self.uri)
        self.listener.close()
        self.api.shutdown()
        self.api.server_close()


class DeafSubscriber:
    """Connects to the publisher of a topic and never reads what it is sent."""

    def __init__(self, name, topic, kind):
        master = rosgraph.Master(name)
        publishers = dict(master.getSystemState()[0])[topic]
        api = xmlrpc.client.ServerProxy(master.lookupNode(publishers[0]))
        _, _, (_, host, port) = api.requestTopic(name, topic, [["TCPROS"]])
        self.connection = socket.create_connection((host, port))
        self.connection.sendall(header(callerid=name, topic=topic, type=kind._type, md5sum=kind._md5sum))

    def close(self):
        self.connection.close()
